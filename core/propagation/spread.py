"""How a signal spreads: the strongest arrival at every node from any of the sources, and where it came from.

All implied intra-connections of a frame can't be drawn, and say little: this tree of strongest arrivals has at most one connection per
node and shows where the signal goes.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..graph import HapticGraph
from ..scene import Settings
from .best_path import PathTree, cost_of, path_tree
from .modes import cost_limit

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Spread:
    """``gain`` (n,): the largest product from any source to each node, the source's amplitude included, 0 where nothing arrives;
    a source's own node has its amplitude. ``predecessor`` (n,): the node that it came from, -1 at sources and where nothing arrives.
    Following predecessors never comes back to a node, and never lowers the gain."""

    gain: FloatArray
    predecessor: IntArray


def spread(graph: HapticGraph, settings: Settings, sources: Collection[str] | None = None) -> Spread:
    """The spread from all sources of ``graph``, or from those named in ``sources``, within the two limits of ``settings``. The graph is
    taken as it is: a rendering that exchanges its functions does so before."""
    gain = np.zeros(graph.node_count)
    predecessor = np.full(graph.node_count, -1, dtype=np.int64)
    roots = [
        (source.amplitude, node)
        for source in graph.sources
        if source.amplitude > 0 and (sources is None or source.name in sources)
        for node in source.nodes
    ]
    limit = cost_limit(settings.threshold) + 1e-9
    for amplitude, root in roots:
        reached, came_from = _arrivals(graph, path_tree(graph, root, limit), limit, settings.max_connections)
        stronger = amplitude * reached > gain
        gain[stronger] = amplitude * reached[stronger]
        predecessor[stronger] = came_from[stronger]
    return Spread(gain, predecessor)


def _arrivals(graph: HapticGraph, tree: PathTree, cost_limit: float, max_connections: int | None) -> tuple[FloatArray, IntArray]:
    """Gain and predecessor of every node in one tree, by whichever connection brings more."""
    crossed = graph.partner >= 0
    over = np.where(crossed, graph.partner, 0)
    length = _connections(graph, tree)
    inside = tree.arrival.copy()
    across = np.full(graph.node_count, np.inf)
    across[crossed] = tree.arrival[over[crossed]] + cost_of(graph.transmission)[graph.contact[crossed]]
    across[across > cost_limit] = np.inf
    if max_connections is not None:
        inside[length > max_connections] = np.inf
        across[length[over] + 1 > max_connections] = np.inf
    # Of equal ways the shorter one, so that following predecessors always comes closer to the source.
    crosses = (across < inside) | ((across == inside) & (length[over] + 1 < length))
    cost = np.minimum(inside, across)
    came_from = np.where(np.isinf(cost), -1, np.where(crosses, over, tree.entry))
    cost[tree.root], came_from[tree.root] = 0.0, -1
    return np.exp(-cost), came_from


def _connections(graph: HapticGraph, tree: PathTree) -> IntArray:
    """Number of connections on the tree's path to each node (arrived at inside its object); 0 where there is none."""
    arrived = np.flatnonzero(tree.entry >= 0)
    entry = tree.entry[arrived]
    before = np.where(entry == tree.root, entry, graph.partner[entry])
    length = np.zeros(graph.node_count, dtype=np.int64)
    pending = np.ones(len(arrived), dtype=np.bool_)
    known = np.zeros(graph.node_count, dtype=np.bool_)
    direct = entry == tree.root
    while pending.any():
        ready = pending & (direct | known[before])
        length[arrived[ready]] = np.where(direct[ready], 1, length[before[ready]] + 2)
        known[arrived[ready]] = True
        pending &= ~ready
    return length
