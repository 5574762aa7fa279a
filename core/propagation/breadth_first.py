"""The paper's sum over paths: breadth-first propagation of a persistent source. All partial paths
with the same number of contacts take their next step at once, as arrays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray, IntArray, ranges
from ..frozen import frozen
from ..graph.haptic_graph import HapticGraph
from .connections import intra_lanes

BUDGET = 1_000_000
"""Most connections that are examined for a source."""

ROUNDING = 1e-12
"""Relative slack of comparisons with the threshold: a gain equal to the threshold meets it despite
rounding of the product."""


@frozen
class PathSums:
    """Sums over the paths from a source.

    Attributes:
        gain: (l, lanes) of each listener: the plain gain, then, where bands are used, that of each
            band.
        paths: (l,) number of paths summed.
        limited: whether the limits or the budget have left out paths, so that a gain is a lower
            bound.
        ended: whether the budget has.
    """

    gain: FloatArray
    paths: IntArray
    limited: bool
    ended: bool


def sums_over_paths(
    graph: HapticGraph,
    roots: Sequence[int],
    max_connections: int | None,
    threshold: float,
    budget: int = BUDGET,
) -> PathSums:
    """The sums over all paths from the nodes ``roots`` of a source to each listener that have at
    most ``max_connections`` (None: any number of them) and whose gain nowhere falls below
    ``threshold``. If the ``budget`` does not suffice for a step, the strongest partial paths take
    it, and the search ends."""
    least = threshold * (1 - ROUNDING)
    most = np.inf if max_connections is None else max_connections
    crossing = graph.crossing_lanes()
    lanes = crossing.shape[1]
    sums = np.zeros((graph.node_count, lanes))
    counts = np.zeros(graph.node_count, dtype=np.int64)
    entry = np.array(roots, dtype=np.int64)
    value = np.ones((len(entry), lanes))
    crossed = np.empty((len(entry), 0), dtype=np.int64)
    heard = np.zeros(graph.node_count, dtype=np.bool_)
    heard[graph.listener_nodes] = True
    limited = ended = False
    connections = 0
    while len(entry):
        index = graph.node_object[entry]
        size = graph.start[index + 1] - graph.start[index]
        spent = size.cumsum()
        if spent[-1] > budget:
            limited = ended = True
            order = value[:, 0].argsort(kind="stable")[::-1]
            order = order[size[order].cumsum() <= budget]
            entry, value, crossed, size = entry[order], value[order], crossed[order], size[order]
        budget -= int(size.sum())
        which = np.arange(len(entry)).repeat(size)
        other = ranges(graph.start[graph.node_object[entry]], size)
        onwards = np.where(
            graph.contact[other] >= 0,
            (crossed[which] != graph.contact[other][:, None]).all(axis=1),
            heard[other],
        )
        chosen = (onwards & (other != entry[which])).nonzero()[0]
        which, other = which[chosen], other[chosen]
        connections += 1
        gain = value[which] * intra_lanes(graph, entry[which], other)
        kept = (gain[:, 0] > 0) & (gain[:, 0] >= least) & (connections <= most)
        limited |= bool((gain[~kept, 0] > 0).any())
        which, other, gain = which[kept], other[kept], gain[kept]
        np.add.at(sums, other, gain)
        np.add.at(counts, other, 1)
        over = (graph.contact[other] >= 0).nonzero()[0]
        which, other = which[over], other[over]
        connections += 1
        value = gain[over] * crossing[other]
        kept = (value[:, 0] > 0) & (value[:, 0] >= least) & (connections <= most)
        limited |= bool((value[~kept, 0] > 0).any())
        which, other, value = which[kept], other[kept], value[kept]
        entry = graph.partner[other]
        crossed = np.column_stack([crossed[which], graph.contact[other]])
        if ended:
            break
    listeners = graph.listener_nodes
    return PathSums(sums[listeners], counts[listeners], limited, ended)
