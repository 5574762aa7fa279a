"""Costs, band gains and delays of connections and of paths, and whether some gain exceeds 1."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray, IntArray
from ..graph.haptic_graph import HapticGraph, distances
from ..scene.bands import BAND_COUNT

ROUNDING = 1e-12
"""Relative slack of comparisons with the threshold: one that is met exactly stays met, however the product is rounded."""

SLACK = 1e-9
"""Costs along a tree are rounded sums, so trees reach this far beyond a limit; the path found is judged by its exactly rounded cost."""

LARGEST = 1e300
"""Gains and sums above this are cut to this, as lower bounds."""

PAIRS_EVALUATED = 1 << 18
"""Most intra-connections of one object evaluated to see whether a function whose bounds allow gains above 1 has any."""


def bounded_exp(x: float) -> float:
    """``exp(x)``, at most `LARGEST`."""
    return math.exp(x) if x < math.log(LARGEST) else LARGEST


def cost_of(gain: FloatArray) -> FloatArray:
    """``-log(gain)``; infinite for gain 0."""
    with np.errstate(divide="ignore"):
        return np.asarray(-np.log(gain))


def cost_limit(threshold: float) -> float:
    """Largest cost that meets the threshold, with slack for rounding."""
    return math.inf if threshold == 0 else -math.log(threshold) + ROUNDING


def intra_costs(graph: HapticGraph, a: IntArray, b: IntArray) -> FloatArray:
    """Costs of the intra-connections between nodes ``a[i]`` and ``b[i]`` of one object each."""
    constant, varying = graph.table.costs(graph.node_object[a], graph.node_distances(a, b))
    constant += varying
    return constant


def intra_gains(graph: HapticGraph, a: IntArray, b: IntArray) -> tuple[FloatArray, FloatArray]:
    """Gains of the intra-connections between nodes ``a[i]`` and ``b[i]``, and distances in metres."""
    distance = graph.node_distances(a, b)
    return graph.table.gains(graph.node_object[a], distance), distance


def band_factors(graph: HapticGraph, index: IntArray, distance: FloatArray) -> FloatArray:
    """Gain in each band (n, bands), relative to the plain one, of intra-connections in objects ``index``."""
    factors = np.ones((len(index), BAND_COUNT))
    if graph.table.band_gains is not None:
        factors *= graph.table.band_gains[index]
    if graph.table.band_decays is not None:
        factors *= np.exp(-graph.table.band_decays[index] * distance[:, None])
    return factors


class _Hops(NamedTuple):
    """The connections of several paths, one after the other: from nodes ``a`` to ``b`` (n,); numbers of those ``inside`` objects and of
    those ``across`` contacts, the others lead from one path to the next. ``ends``: number of nodes up to the end of each path."""

    a: IntArray
    b: IntArray
    inside: IntArray
    across: IntArray
    ends: list[int]


def _hops(graph: HapticGraph, paths: Sequence[tuple[int, ...]]) -> _Hops:
    nodes = np.array([node for path in paths for node in path], dtype=np.int64)
    a, b = nodes[:-1], nodes[1:]
    ends = list(itertools.accumulate(map(len, paths)))
    joints = [end - 1 for end in ends[:-1]]  # between the last node of a path and the first of the next
    across = graph.partner[a] == b
    inside = ~across
    across[joints] = inside[joints] = False
    return _Hops(a, b, inside.nonzero()[0], across.nonzero()[0], ends)


def path_costs(graph: HapticGraph, paths: Sequence[tuple[int, ...]]) -> list[float]:
    """The cost ``-log(gain)`` of each path: the exactly rounded sum of the costs of its connections."""
    if not paths:
        return []
    a, b, here, crossed, ends = _hops(graph, paths)
    constant, varying = np.zeros(len(a)), np.zeros(len(a))
    constant[here], varying[here] = graph.table.costs(graph.node_object[a[here]], graph.node_distances(a[here], b[here]))
    constant[crossed] = graph.transmission_loss[graph.contact[a[crossed]]]
    constants, variables = constant.tolist(), varying.tolist()
    costs = []
    for first, last in zip([0, *ends], ends, strict=False):
        terms = constants[first : last - 1] + variables[first : last - 1]
        costs.append(math.fsum(terms) if math.isfinite(sum(terms)) else math.inf)
    return costs


def path_bands(graph: HapticGraph, paths: Sequence[tuple[int, ...]]) -> FloatArray:
    """Gain of each path in each band (p, bands), relative to its plain gain."""
    if not paths:
        return np.ones((0, BAND_COUNT))
    a, b, here, crossed, ends = _hops(graph, paths)
    factors = np.ones((len(a), BAND_COUNT))
    factors[here] = band_factors(graph, graph.node_object[a[here]], graph.node_distances(a[here], b[here]))
    if graph.contact_band_gains is not None:
        factors[crossed] = graph.contact_band_gains[graph.contact[a[crossed]]]
    return np.asarray(np.multiply.reduceat(factors, [0, *ends[:-1]], axis=0))


def path_delay(graph: HapticGraph, path: tuple[int, ...]) -> float:
    """Delay of a path [s]: distance over wave speed inside the objects, plus the delays of the contacts."""
    delays = []
    for a, b in itertools.pairwise(path):
        if graph.partner[a] == b:
            if graph.contact_delay is not None:
                delays.append(float(graph.contact_delay[graph.contact[a]]))
        elif graph.table.slowness is not None:
            distance = float(graph.node_distances(np.array([a]), np.array([b]))[0])
            delays.append(float(graph.table.slowness[graph.node_object[a]]) * distance)
    return math.fsum(delays)


def amplifying(graph: HapticGraph) -> bool:
    """Whether some connection of the graph has a gain above 1, by the bounds of its function or, where these are loose, by its values."""
    if np.any(graph.transmission > 1) or np.any(graph.table.loss < 0):
        return True
    for index in sorted(graph.table.special):
        nodes = graph.nodes_of(index)
        count = nodes.stop - nodes.start
        if count < 2:
            continue
        positions = graph.node_position[nodes]
        extent = float(distances(positions.min(axis=0), positions.max(axis=0)))
        if graph.table.gain_bounds(index, extent)[1] <= 1:
            continue
        if count * (count - 1) // 2 > PAIRS_EVALUATED:
            return True
        first, second = np.triu_indices(count, 1)
        if np.any(graph.table.gain(index, graph.node_distances(nodes.start + first, nodes.start + second)) > 1):
            return True
    return False
