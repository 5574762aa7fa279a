"""Hop-constrained shortest paths: right under a limit of connections, and for gains above 1.

Round k finds the nodes that get cheaper with k contacts than with fewer (R. Bellman, "On a routing
problem", Quarterly of Applied Mathematics 16, 1958). Costs may be negative. The results are walks:
with negative costs, or functions that are no metric plus a constant, the cheapest one may cross a
contact twice. A caller that needs a path checks that, and has a bound in any case.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray, IntArray, portions, ranges, runs
from ..frozen import frozen
from ..graph.haptic_graph import HapticGraph
from .connections import intra_costs

CHUNK = 1 << 18
"""Connections relaxed in one vectorised step, a bound on memory."""


@frozen
class HopConstrainedPaths:
    """Cheapest walks by number of contacts crossed.

    Attributes:
        changes: of each number k of contacts: the nodes (sorted) that get cheaper with k contacts,
            their costs, and the nodes through which their object is entered.
        complete: False where more contacts would change something.
        relaxed: number of connections relaxed.
    """

    changes: tuple[tuple[IntArray, FloatArray, IntArray], ...]
    complete: bool
    relaxed: int

    def visited(self) -> int:
        """Number of nodes reached."""
        return (
            len(np.unique(np.concatenate([nodes for nodes, _, _ in self.changes])))
            if self.changes
            else 0
        )

    def costs(self, count: int) -> FloatArray:
        """(k, n) least cost of arriving at each of ``count`` nodes with at most k contacts."""
        table = np.full((max(1, len(self.changes)), count), math.inf)
        for k, (nodes, cost, _) in enumerate(self.changes):
            if k:
                table[k] = table[k - 1]
            table[k, nodes] = cost
        return table

    def walk(
        self, graph: HapticGraph, target: int, crossings: int | None = None
    ) -> tuple[int, ...]:
        """Nodes of the cheapest walk to ``target`` with at most ``crossings`` contacts; () where
        nothing arrives."""
        nodes: list[int] = []
        node = target
        k = len(self.changes) - 1 if crossings is None else crossings
        while k >= 0:
            changed, _, entry = self.changes[k]
            place = int(np.searchsorted(changed, node))
            if place < len(changed) and changed[place] == node:
                nodes += [node, int(entry[place])]
                node = int(graph.partner[nodes[-1]])
                if node < 0:
                    return tuple(reversed(nodes))
            k -= 1
        return ()


def hop_constrained_paths(
    graph: HapticGraph, roots: Sequence[int], limit: float, crossings: int, complete: bool = False
) -> HopConstrainedPaths:
    """The cheapest walks from nodes to all others over a limited number of contacts.

    Args:
        graph: the scene.
        roots: nodes at which walks begin.
        limit: largest cost of a walk and of each of its beginnings.
        crossings: most contacts that a walk crosses.
        complete: as in `shortest_paths`.
    """
    count = graph.node_count
    arrival = np.full(count, math.inf)
    crossing = np.append(graph.transmission_loss, math.inf)[graph.contact]
    # False for functions without a closed form, whose loss is NaN.
    metric = graph.table.loss >= 0
    node = np.array(roots, dtype=np.int64)
    cost = np.zeros(len(roots))
    changes: list[tuple[IntArray, FloatArray, IntArray]] = []
    complete = complete or bool(graph.table.special)
    origin = np.full(count, -1, dtype=np.int64)
    relaxed = 0
    for _ in range(crossings + 1):
        index = graph.node_object[node]
        useful = ~metric[index] | (arrival[node] > cost + graph.table.loss[index])
        best = arrival.copy()
        entry = np.full(count, -1, dtype=np.int64)
        if complete and not useful.all():
            back = np.flatnonzero(~useful & (origin[node] >= 0))
            relaxed += _relax(
                graph,
                node[back],
                cost[back],
                limit,
                np.arange(len(back)),
                origin[node[back]],
                best,
                entry,
            )
        node = node[useful]
        cost = cost[useful]
        index = index[useful]
        size = np.diff(graph.start)[index]
        for chosen in portions(size, CHUNK):
            which = np.repeat(chosen, size[chosen])
            other = ranges(graph.start[index[chosen]], size[chosen])
            relaxed += _relax(graph, node, cost, limit, which, other, best, entry)
        changed = np.flatnonzero(entry >= 0)
        if len(changed) == 0:
            return HopConstrainedPaths(tuple(changes), True, relaxed)
        arrival = best
        origin[changed] = entry[changed]
        changes.append((changed, best[changed], entry[changed]))
        onwards = best[changed] + crossing[changed]
        go = (onwards <= limit) & (onwards < math.inf)
        node = graph.partner[changed[go]]
        cost = onwards[go]
    return HopConstrainedPaths(tuple(changes), len(node) == 0, relaxed)


def _relax(
    graph: HapticGraph,
    node: IntArray,
    cost: FloatArray,
    limit: float,
    which: IntArray,
    other: IntArray,
    best: FloatArray,
    entry: IntArray,
) -> int:
    """Cross objects once: lower the costs ``best`` of nodes, and note where their objects were
    entered. Returns the number of connections tried.

    Args:
        graph: the scene.
        node: through which objects are entered (k,).
        cost: of getting there (k,).
        limit: largest cost of a walk.
        which: of the entries (m,), each for a connection.
        other: node at the other end of the connection (m,).
        best: cost of each node (n,), which is changed.
        entry: node through which the object of each node was entered (n,), which is changed.
    """
    candidate = cost[which] + intra_costs(graph, node[which], other)
    better = np.flatnonzero(
        (candidate < best[other]) & (candidate <= limit) & (other != node[which])
    )
    order = better[np.lexsort((node[which[better]], candidate[better], other[better]))]
    chosen = order[runs(other[order])[0]]
    best[other[chosen]] = candidate[chosen]
    entry[other[chosen]] = node[which[chosen]]
    return len(other)
