"""Shortest paths on a graph whose intra-connections are implied: Dijkstra's algorithm from many
roots at once (E. W. Dijkstra, Numerische Mathematik 1, 1959).

Costs are ``-log(gain)``, 0 or more. One step is an intra- and an inter-connection together: from
the node through which an object is entered to every other node of the object, and on over their
contacts. So no two intra-connections follow each other, whatever the objects' functions are. What
is pending is taken in batches, the cheapest first (D. P. Bertsekas, *Network Optimization*, 1998,
section 2.4), so that a step is a few operations on arrays.

A hub of n contacts costs O(n), not O(n²): let the cost inside an object be ``a + m``, a >= 0 and m
a metric, and let node x have been reached inside it at the cost A(x) from an entry e. Entering
through x at a cost E(x) >= A(x) - a improves nothing: for every node y of the object, ``E(x) + a +
m(x, y) >= A(x) + m(x, y) = E(e) + a + m(e, x) + m(x, y) >= E(e) + a + m(e, y)``, by the triangle
inequality. So once a cheap entry has been taken, each other entry of the object drops out with one
comparison. The argument does not cover y = e: that single connection matters only where the object
beyond the contact of e has a function of another form, and is examined there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, ranges
from ..frozen import frozen
from ..graph.haptic_graph import HapticGraph

LIMIT = math.log(1e6)
"""Cost at which the search ends: -120 dB."""

BATCH = 1 << 15
"""Connections examined in one step: enough to outweigh its overhead, few enough that later entries
gain from earlier ones."""


@frozen
class ShortestPaths:
    """Shortest-path trees: costs and predecessors per set of roots (row) and node.

    Attributes:
        cost: (r, n) cost of arriving at each node inside its object; infinite where nothing
            arrives.
        entry: (r, n) the node through which that object was entered (a root in its own object), or
            -1.
        cut: (r,) whether the limit has ended some path.
        examined: number of connections examined.
    """

    cost: FloatArray
    entry: IntArray
    cut: BoolArray
    examined: int


def shortest_paths(
    graph: HapticGraph,
    roots: Sequence[Sequence[int]],
    bands: Sequence[int] | None = None,
    targets: Sequence[IntArray] | None = None,
    backwards: bool = False,
    limit: float = LIMIT,
) -> ShortestPaths:
    """Shortest-path trees from each set of roots.

    Args:
        graph: the scene.
        roots: source or listener nodes, one set per row.
        bands: of each row the frequency band whose gains count, by default those without bands.
        targets: of each row the nodes of interest, one or more; its search ends where none of them
            can get cheaper. None: all.
        backwards: paths lead from the nodes to the roots, which matters where a contact's two
            directions differ.
        limit: largest cost of a path.
    """
    row = np.array([r for r, nodes in enumerate(roots) for _ in nodes], dtype=np.int64)
    node = np.array([n for nodes in roots for n in nodes], dtype=np.int64)
    search = _Search(graph, len(roots), bands, targets, backwards, limit)
    pending = row, node, np.zeros(len(node))
    while len(pending[0]):
        now, later = search.cheapest(*pending)
        reached = search.inside(*now)
        pending = search.across(*reached, later)
    return search.result()


Entries = tuple[IntArray, IntArray, FloatArray]
"""Row, node and cost (k,) of entries: an object is entered through the node at that cost."""


class _Search:
    """State of the search: the costs and entries so far.

    Arrays that depend on the frequency band hold those of one band after the other; ``lane`` says
    where those of a row begin.
    """

    def __init__(
        self,
        graph: HapticGraph,
        rows: int,
        bands: Sequence[int] | None,
        targets: Sequence[IntArray] | None,
        backwards: bool,
        limit: float,
    ) -> None:
        self.graph, self.count = graph, graph.node_count
        self.limit = min(limit, 1e300)
        self.limits = np.full(rows, self.limit)
        self.cut = np.zeros(rows, dtype=np.bool_)
        # A cost begins just above the limit, so that a path beyond the limit is no improvement.
        self.arrival = np.full(rows * self.count, np.nextafter(self.limit, math.inf))
        self.entering = np.full(rows * self.count, math.inf)  # least cost of entering at each node
        self.entry = np.full(rows * self.count, -1, dtype=np.int64)
        used = sorted(set(bands or ()))
        views = [graph.in_band(band) for band in used] or [graph]
        self.loss = np.concatenate([view.table.loss for view in views])
        self.decay = np.concatenate([view.table.decay for view in views])
        self.crossing = np.concatenate([view.crossing_costs(backwards) for view in views])
        self.lane = np.array([used.index(band) for band in bands or ()] or [0] * rows)
        self.special = np.zeros(len(graph.table.names), dtype=np.bool_)
        self.special[list(graph.table.special)] = True
        self.sought: IntArray | None = None
        if targets is not None:
            size = np.array([len(nodes) for nodes in targets])
            self.sought = np.concatenate(targets)
            self.sought += (np.arange(rows) * self.count).repeat(size)
            self.first_sought = size.cumsum() - size
        self.examined = 0

    def cheapest(self, row: IntArray, node: IntArray, cost: FloatArray) -> tuple[Entries, Entries]:
        """The cheapest of the pending entries, as many as a step examines, and the others. Those
        that improve nothing drop out."""
        graph = self.graph
        place = row * self.count + node
        index = graph.node_object[node]
        base = cost + self.loss[self.lane[row] * len(self.special) + index]
        useful = self.arrival[place] > base
        if graph.table.special:
            useful |= self.special[index] | self._returns(place)
        # Others have become cheaper since, or are of no interest any more.
        useful &= (cost <= self.entering[place]) & (cost <= self.limits[row])
        kept = useful.nonzero()[0]
        row, node, cost = row[kept], node[kept], cost[kept]
        work = graph.size_around(node).cumsum()
        if len(work) == 0 or work[-1] <= BATCH:
            return (row, node, cost), (row[:0], node[:0], cost[:0])
        order = np.lexsort((node, row, cost))
        work = graph.size_around(node[order]).cumsum()
        count = max(1, int(work.searchsorted(BATCH, side="right")))
        now, later = order[:count], order[count:]
        return (row[now], node[now], cost[now]), (row[later], node[later], cost[later])

    def _returns(self, place: IntArray) -> BoolArray:
        """Whether the object beyond the entry from which a place was reached is a special one."""
        graph = self.graph
        beyond = graph.partner[self.entry[place]]
        found = (self.entry[place] >= 0) & (beyond >= 0)
        return np.asarray(found & self.special[graph.node_object[beyond]])

    def inside(
        self, row: IntArray, node: IntArray, cost: FloatArray
    ) -> tuple[IntArray, IntArray, FloatArray]:
        """Go on from entries to all other nodes of their objects. Returns row, node and cost of
        those that have become cheaper."""
        graph = self.graph
        index = graph.node_object[node]
        size = graph.size_around(node) - 1
        which = np.arange(len(row)).repeat(size)
        other = ranges(graph.start[index], size)
        other += other >= node[which]
        begin = node[which]
        self.examined += len(other)
        lane = self.lane[row] * len(self.special) + index
        candidate = (cost + self.loss[lane])[which]
        distance = graph.node_distances(begin, other)
        candidate += self.decay[lane][which] * distance
        if graph.table.spreading is not None:
            candidate += graph.table.spreading.cost(
                index[which], distance, graph.ends(begin, other)
            )
        for number in set(index.tolist()) & graph.table.special:
            chosen = (index[which] == number).nonzero()[0]
            with np.errstate(divide="ignore"):
                candidate[chosen] = cost[which[chosen]] - np.log(
                    graph.table.gain(number, distance[chosen])
                )
        self.cut[row[which[(candidate > self.limit).nonzero()[0]]]] = True
        place = (row * self.count)[which] + other
        better = (candidate < self.arrival[place]).nonzero()[0]
        place, begin, candidate = place[better], begin[better], candidate[better]
        # Several connections to one node: the cheapest wins, among equal ones that from the lowest
        # entry.
        np.minimum.at(self.arrival, place, candidate)
        cheapest = (candidate == self.arrival[place]).nonzero()[0]
        better, place, begin = better[cheapest], place[cheapest], begin[cheapest]
        self.entry[place] = self.count
        np.minimum.at(self.entry, place, begin)
        better = better[self.entry[place] == begin]
        place = (row * self.count)[which[better]] + other[better]
        return row[which[better]], other[better], self.arrival[place]

    def across(self, row: IntArray, node: IntArray, cost: FloatArray, later: Entries) -> Entries:
        """Go on from nodes over their contacts. Returns the new entries beside the pending ones."""
        if self.sought is not None:  # no more than what each target costs now is of interest
            dearest = np.maximum.reduceat(self.arrival[self.sought], self.first_sought)
            np.minimum(self.limits, dearest, out=self.limits)
        cost = cost + self.crossing[self.lane[row] * self.count + node]
        node = self.graph.partner[node]
        self.cut[row[((cost > self.limit) & (node >= 0)).nonzero()[0]]] = True
        place = row * self.count + node
        go = ((cost <= self.limits[row]) & (cost < self.entering[place])).nonzero()[0]
        row, node, cost = row[go], node[go], cost[go]
        self.entering[place[go]] = cost
        if len(later[0]) == 0:
            return row, node, cost
        merged = zip(later, (row, node, cost), strict=True)
        row, node, cost = (np.concatenate(both) for both in merged)
        return row, node, cost

    def result(self) -> ShortestPaths:
        self.arrival[self.entry < 0] = math.inf
        shape = len(self.limits), self.count
        return ShortestPaths(
            self.arrival.reshape(shape), self.entry.reshape(shape), self.cut, self.examined
        )
