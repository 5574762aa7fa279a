"""Costs and gains of connections inside objects."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray
from ..graph.haptic_graph import HapticGraph
from ..scene.bands import BAND_COUNT


def intra_costs(graph: HapticGraph, a: IntArray, b: IntArray) -> FloatArray:
    """Costs ``-log(gain)`` of the intra-connections between nodes ``a[i]`` and ``b[i]`` of one
    object each."""
    constant, varying = graph.table.costs(
        graph.node_object[a], graph.node_distances(a, b), graph.ends(a, b)
    )
    constant += varying
    return constant


def intra_lanes(graph: HapticGraph, a: IntArray, b: IntArray) -> FloatArray:
    """Gains (n, lanes) of the intra-connections between nodes ``a[i]`` and ``b[i]``: the plain
    gain, then, where bands are used, that of each band."""
    index = graph.node_object[a]
    distance = graph.node_distances(a, b)
    gains = graph.table.gains(index, distance, graph.ends(a, b))[:, None]
    if not graph.uses_bands:
        return gains
    return np.concatenate([gains, gains * np.exp(-band_costs(graph, index, distance))], axis=1)


def band_costs(graph: HapticGraph, index: IntArray, distance: FloatArray) -> FloatArray:
    """Cost in each band (n, bands), beyond the plain one, of intra-connections in objects
    ``index`` (n,) over ``distance`` (n,)."""
    table = graph.table
    costs = np.zeros((len(index), BAND_COUNT))
    if table.band_gains is not None:
        with np.errstate(divide="ignore"):
            costs -= np.log(table.band_gains)[index]
    if table.band_decays is not None:
        costs += table.band_decays[index] * distance[:, None]
    return costs
