"""The strongest path between sources and listeners, on the graph whose intra-connections are implied.

Costs are ``-log(gain)``. A node has two labels: the cost of entering its object through it (by an inter-connection) and the cost of
arriving at it inside its object (by an intra-connection); the second is left through the inter-connection only, which is the rule that no
two intra-connections follow each other.

Source: E. W. Dijkstra, "A note on two problems in connexion with graphs", Numerische Mathematik 1, 1959.
"""

from __future__ import annotations

import heapq
import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..graph import HapticGraph

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

ROUNDING = 1e-12
"""Relative slack of every comparison with a threshold: one that is met exactly stays met whatever the rounding of the product."""


def cost_of(gain: FloatArray) -> FloatArray:
    """``-log(gain)``; infinite for gain 0."""
    with np.errstate(divide="ignore"):
        return np.asarray(-np.log(gain))


@dataclass(frozen=True, slots=True)
class PathTree:
    """Cheapest ways from one node. ``arrival`` (n,) cost of arriving at a node inside its object; ``entry`` (n,) the node through which
    that object was entered (the root itself in its own object), -1 where nothing arrives."""

    root: int
    arrival: FloatArray
    entry: IntArray

    def path(self, graph: HapticGraph, target: int) -> tuple[int, ...]:
        """The nodes from the root to ``target``, () where it is not reached."""
        if self.entry[target] < 0:
            return ()
        nodes = [target]
        node = target
        while True:
            node = int(self.entry[node])
            nodes.append(node)
            if node == self.root:
                return tuple(reversed(nodes))
            node = int(graph.partner[node])
            nodes.append(node)


def path_tree(graph: HapticGraph, root: int, cost_limit: float) -> PathTree:
    """Cheapest ways from ``root`` to every node within ``cost_limit``."""
    count = graph.node_count
    arrival = np.full(count, math.inf)
    entry = np.full(count, -1, dtype=np.int64)
    crossing = cost_of(graph.transmission)
    settled = np.zeros(count, dtype=np.bool_)
    queue = [(0.0, root)]
    while queue:
        cost, node = heapq.heappop(queue)
        if settled[node]:
            continue
        settled[node] = True
        index = int(graph.node_object[node])
        nodes = graph.nodes_of(index)
        candidate = cost + cost_of(graph.intra_gain(index, node, nodes))
        candidate[node - nodes.start] = math.inf
        better = np.flatnonzero((candidate < arrival[nodes]) & (candidate <= cost_limit)) + nodes.start
        arrival[better] = candidate[better - nodes.start]
        entry[better] = node
        for other in better.tolist():
            partner = int(graph.partner[other])
            if partner >= 0:
                total = float(arrival[other] + crossing[graph.contact[other]])
                if total <= cost_limit and not settled[partner]:
                    heapq.heappush(queue, (total, partner))
    return PathTree(root, arrival, entry)


def path_gain(graph: HapticGraph, nodes: tuple[int, ...]) -> float:
    """Gain of a path: the exponential of the exactly rounded sum of its costs, so that long chains lose no digits."""
    costs = []
    for a, b in itertools.pairwise(nodes):
        if graph.partner[a] == b and graph.contact[a] >= 0:
            costs.append(float(cost_of(graph.transmission[graph.contact[a]])))
        else:
            index = int(graph.node_object[a])
            costs.append(float(cost_of(graph.intra_gain(index, a, np.array([b])))[0]))
    return math.exp(-math.fsum(costs))
