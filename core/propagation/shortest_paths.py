"""Single-source shortest paths on a graph whose intra-connections are implied.

Edge costs are ``-log(gain)`` and never negative. Two costs belong to a node: that of *entering* its
object through it, over its inter-connection, and that of *arriving* at it inside its object, over
an intra-connection. What has arrived leaves through the inter-connection only: so no two
intra-connections follow each other, whatever the objects' functions are.

An object is relaxed in one vectorised step, from many entries of many roots at once, the cheapest
first (a label-correcting method in batches: D. P. Bertsekas, *Network Optimization*, 1998, section
2.4). Where few entries are pending, as along a chain, Dijkstra's algorithm with a binary heap takes
over (E. W. Dijkstra, Numerische Mathematik 1, 1959).

A hub of n contacts costs O(n), not O(n²): let the cost inside an object be ``a + m``, a >= 0 and m
a metric, and let node x have been reached inside it at the cost A(x) from an entry e. Entering
through x at a cost E(x) >= A(x) - a improves nothing: for every node y of the object, ``E(x) + a +
m(x, y) >= A(x) + m(x, y) = E(e) + a + m(e, x) + m(x, y) >= E(e) + a + m(e, y)``, by the triangle
inequality. So once a cheap entry has been relaxed, each other entry of the object drops out with
one comparison. The argument does not cover y = e. That single connection is relaxed where it
matters (`complete`): for the cost from e to a root by a path that does not lead back through e's
own contact, and where the object beyond that contact has a function of another form. Otherwise no
shortest path returns to the contact of a cheaper entry.

Where waves spread, more entries drop out, those of a ground on which bodies conduct better than
itself. Let E(x) be less than A(x) - a. It can lower the cost of y only if the detour ``m(e, x) +
m(x, y) - m(e, y)`` is less than ``A(x) - a - E(x)``. As m is a concave function of distance, the
detour grows with the distance from x to y, and is least where x lies between e and y. Where even
that of a node as near as the nearest one is too long, x drops out (`_improving`).
"""

from __future__ import annotations

import heapq
import math
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, ranges
from ..frozen import frozen
from ..graph.haptic_graph import HapticGraph
from ..scene.functions.spreading import Law
from .connections import SLACK, intra_costs
from .spacing import spacing

BATCH = 1 << 15
"""Connections relaxed in one vectorised step: enough to outweigh its overhead, few enough that
later entries gain from earlier ones."""

SPARSE_ROUNDS, SPARSE = 32, 300
"""After this many steps with fewer relaxed connections each on average, the heap is faster."""

FEW = 400
"""Up to this many root and node pairs the heap is faster from the beginning."""

SMALL = 1024
"""Up to this many nodes or objects, arrays are copied into lists for access element by element."""

KEPT_AFTER, MOST_KEPT = 0.5, 1 << 20
"""Once so many have been relaxed for each intra-connection, the distances of all are kept, unless
these are too many; counted from each end, and from each node to itself."""

POINT = 0.0, 0.0
"""The front of a node whose patch is a point."""

LARGE = 48
"""From this many nodes on, Dijkstra's algorithm relaxes an object as an array."""


@frozen
class ShortestPaths:
    """Shortest-path trees: costs and predecessors per set of roots (row) and node.

    Attributes:
        cost: (r, n) cost of arriving inside the node's object; infinite where nothing arrives.
        entry: (r, n) the node through which that object was entered (a root in its own object), or
            -1.
        relaxed: number of connections relaxed.
    """

    cost: FloatArray
    entry: IntArray
    relaxed: int

    def visited(self) -> int:
        """Number of nodes reached, the largest over the sets of roots."""
        return max(map(int, map(np.count_nonzero, self.entry >= 0)), default=0)

    def paths(
        self,
        graph: HapticGraph,
        row: IntArray,
        one: IntArray,
        other: IntArray,
        backwards: BoolArray,
    ) -> list[tuple[int, ...]]:
        """Nodes of the shortest paths (p,) from a root of each row to the nearer of two targets; ()
        where nothing arrives.

        Args:
            graph: the scene.
            row: the tree of each path (p,).
            one: a target (p,).
            other: the other target (p,), or the same.
            backwards: which paths are given from the target to the root (p,).
        """
        cost = self.cost[row, one]
        another = self.cost[row, other]
        node = np.where((another < cost) | ((another == cost) & (other < one)), other, one)
        node[self.entry[row, node] < 0] = -1
        steps = [node]
        while (node >= 0).any():
            begin = np.where(node >= 0, self.entry[row, node], -1)
            node = np.where(begin >= 0, graph.partner[begin], -1)
            steps += [begin, node]
        nodes = np.array(steps[::-1]).T
        nodes[backwards] = nodes[backwards, ::-1]
        there = nodes >= 0
        flat = nodes[there].tolist()
        ends = there.sum(axis=1).cumsum().tolist()
        return [tuple(flat[begin:end]) for begin, end in zip([0, *ends], ends, strict=False)]


class _Relaxation:
    """State of the relaxation: costs and entries so far, and what every step reads."""

    def __init__(
        self,
        graphs: Sequence[HapticGraph],
        limits: FloatArray,
        targets: Sequence[IntArray] | None,
        complete: bool,
    ) -> None:
        self.graph = graphs[0]
        rows = len(graphs)
        graph = self.graph
        self.count = graph.node_count
        views = list({id(one): one for one in graphs}.values())
        self.views = (
            [next(k for k, one in enumerate(views) if one is wanted) for wanted in graphs]
            if len(views) > 1
            else [0] * rows
        )
        """Per row: which of the ``tables`` it is searched by. Arrays below that depend on the table
        hold one after the other."""
        self.limits = np.minimum(limits, sys.float_info.max / 2)
        # A node's cost begins just above the limit of its row, so that a path beyond the limit is
        # no improvement.
        self.arrival = np.nextafter(self.limits, math.inf)[:, None].repeat(self.count, axis=1)
        self.entry = np.full((rows, self.count), -1, dtype=np.int64)
        self.targets = targets
        self.complete = complete or bool(graph.table.special)
        self.tables = [one.table for one in views]
        # Per node: cost of its inter-connection; contact -1 takes the appended infinity.
        self.crossing = np.concatenate(
            [
                np.maximum(0.0, np.concatenate([one.transmission_loss, [math.inf]]))[graph.contact]
                for one in views
            ]
        )
        self.relaxed = 0

    def prepare(self) -> None:
        """Make what `_relax_cheapest` reads besides."""
        graph = self.graph
        rows = len(self.views)
        self.shift = (
            np.array(self.views, dtype=np.int64) * self.count if len(self.tables) > 1 else None
        )
        self.arrivals, self.entries = self.arrival.reshape(-1), self.entry.reshape(-1)
        self.entering = np.full(rows * self.count, math.inf)  # least cost of entering at each node
        if self.targets is not None:
            size = np.array([len(nodes) for nodes in self.targets])
            self.sought = np.concatenate(self.targets) + (np.arange(rows) * self.count).repeat(size)
            self.first_sought = size.cumsum() - size
        # Per node, as all that follows: of its object the first node, and the number of nodes
        # besides itself.
        index = graph.node_object
        self.first = graph.start[index]
        self.others = graph.start[index + 1] - self.first - 1
        self.special = np.isin(index, list(graph.table.special)) if graph.table.special else None
        self.node_loss = np.concatenate(
            [np.maximum(0.0, table.loss)[index] for table in self.tables]
        )
        self.node_decay = np.concatenate([table.decay[index] for table in self.tables])
        self.begins = (self.others + 1).cumsum() - self.others - 1 - self.first
        self.connections = int((self.others + 1).sum())
        self.kept: tuple[FloatArray, FloatArray | None] | None = None
        self.is_vast = bool((np.abs(graph.node_position) > 1e150).any())
        self.spacing: FloatArray | None = None  # made when it is worth it

    def table_index(self, row: IntArray, node: IntArray) -> IntArray:
        """Index of a node in the arrays that hold one table after the other, for the table by which
        the ``row`` is searched."""
        return node if self.shift is None else node + self.shift[row]

    def distances(self, begin: IntArray, other: IntArray) -> FloatArray:
        """`HapticGraph.node_distances` without scaling against underflow: distances below 1e-154 m,
        whose squares are 0, change no cost."""
        if self.is_vast:
            return self.graph.node_distances(begin, other)
        x, y, z = (places[begin] - places[other] for places in self.graph.node_position.T)
        distance: FloatArray = np.sqrt(x * x + y * y + z * z)
        reach = self.graph.reach
        return (
            distance if reach is None else np.maximum(distance - (reach[begin] + reach[other]), 0.0)
        )

    def measured(
        self, node: IntArray, which: IntArray, other: IntArray
    ) -> tuple[FloatArray, FloatArray | None]:
        """Distances (m,) from the nodes ``node[which]`` to ``other`` nodes of the same objects, and
        costs of spreading over them (None where no wave spreads), computed once for all if many are
        asked for."""
        if self.kept is None:
            if self.relaxed < KEPT_AFTER * self.connections or self.connections > MOST_KEPT:
                return self._measured(node[which], other)
            size = self.others + 1
            self.kept = self._measured(np.arange(self.count).repeat(size), ranges(self.first, size))
        place = self.begins[node][which] + other
        distance, spread = self.kept
        return distance.take(place), None if spread is None else spread.take(place)

    def _measured(self, begin: IntArray, other: IntArray) -> tuple[FloatArray, FloatArray | None]:
        graph = self.graph
        distance = self.distances(begin, other)
        spreading = graph.table.spreading
        if spreading is None:
            return distance, None
        index = graph.node_object[begin]
        return distance, spreading.cost(index, distance, graph.ends(begin, other))

    def result(self) -> ShortestPaths:
        self.arrival[self.entry < 0] = math.inf
        return ShortestPaths(self.arrival, self.entry, self.relaxed)


def shortest_paths(
    graph: HapticGraph | Sequence[HapticGraph],
    roots: Sequence[Sequence[int]],
    limits: FloatArray,
    targets: Sequence[IntArray] | None = None,
    complete: bool = False,
) -> ShortestPaths:
    """Shortest-path trees from each set of roots.

    Args:
        graph: gains above 1 count as 1. One for each row, where their gains differ by frequency
            band, and nothing else.
        roots: source or listener nodes, one set per row.
        limits: (r,) largest cost of interest.
        targets: nodes of interest, one or more for each row; it stops where none of them can get
            cheaper, and is complete only as far as they need. None: all.
        complete: costs are right also for the nodes through which an object is entered.
    """
    work = _Relaxation(
        [graph] * len(roots) if isinstance(graph, HapticGraph) else graph, limits, targets, complete
    )
    row = np.array([r for r, nodes in enumerate(roots) for _ in nodes], dtype=np.int64)
    node = np.array([n for nodes in roots for n in nodes], dtype=np.int64)
    pending = row, node, np.zeros(len(node))
    rounds = 0
    if len(roots) * work.count <= FEW:
        _finish_by_dijkstra(work, *pending)
        return work.result()
    work.prepare()
    while len(pending[0]):
        pending = _relax_cheapest(work, *pending)
        rounds += 1
        if rounds >= SPARSE_ROUNDS and work.relaxed < SPARSE * rounds:
            _finish_by_dijkstra(work, *pending)
            break
    return work.result()


def _relax_cheapest(
    work: _Relaxation, row: IntArray, node: IntArray, cost: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """Relax the cheapest of the pending entries, given by their row, node and cost (k,). Returns
    the entries pending afterwards."""
    place = row * work.count + node
    current = (cost <= work.entering[place]).nonzero()[0]  # the others have become cheaper since
    if len(current) < len(row):
        row = row[current]
        node = node[current]
        cost = cost[current]
        place = place[current]
    base = cost + work.node_loss[work.table_index(row, node)]
    useful = work.arrivals[place] > base
    if work.special is not None:
        useful |= work.special[node]
    batches = []
    if work.complete:
        back = (~useful & (cost <= work.limits[row]) & (work.entry[row, node] >= 0)).nonzero()[0]
        back = back[work.graph.partner[work.entry[row[back], node[back]]] >= 0]
        if len(back):
            which = np.arange(len(back))
            other = work.entry[row[back], node[back]]
            batches.append(
                _relax(work, row[back], node[back], cost[back], base[back], which, other)
            )
    kept = useful.nonzero()[0]
    if len(kept) < len(row):
        row = row[kept]
        node = node[kept]
        cost = cost[kept]
        base = base[kept]
    if len(row):
        size = work.others[node]
        if size.sum() > BATCH and not (work.complete or work.is_vast):
            kept = _improving(work, row, node, base)
            row = row[kept]
            node = node[kept]
            cost = cost[kept]
            base = base[kept]
            size = size[kept]
        if size.sum() > BATCH:
            order = np.lexsort((node, row, cost))
            now = max(1, int(size[order].cumsum().searchsorted(BATCH, side="right")))
            later = order[now:]
            order = order[:now]
            batches.append((row[later], node[later], cost[later]))
            row = row[order]
            node = node[order]
            cost = cost[order]
            base = base[order]
            size = size[order]
        which = np.arange(len(row)).repeat(size)
        other = ranges(work.first[node], size)
        other += other >= node[which]  # all nodes of the object but the entry itself
        batches.append(_relax(work, row, node, cost, base, which, other))
    if len(batches) == 1:
        return batches[0]
    if not batches:
        return row, node, cost
    rows, nodes, costs = zip(*batches, strict=True)
    return np.concatenate(rows), np.concatenate(nodes), np.concatenate(costs)


def _improving(work: _Relaxation, row: IntArray, node: IntArray, base: FloatArray) -> IntArray:
    """Numbers of those entries that may lower costs in their object, given by row, node, and cost
    with the constant loss of the object (k,)."""
    graph = work.graph
    spreading = graph.table.spreading
    if spreading is None:
        return np.arange(len(row))
    if work.spacing is None:
        work.spacing = spacing(graph)
    before = work.entry[row, node]
    known = (before >= 0) & (work.spacing[node] > 0)
    if graph.fronts is not None:
        run = graph.fronts[0]
        known &= (run[node] == 0) & (run[before] == 0)
    chosen = known.nonzero()[0]
    nodes = node[chosen]
    detour = spreading.detour(
        graph.node_object[nodes], work.distances(before[chosen], nodes), work.spacing[nodes]
    )
    arrival = work.arrival[row[chosen], nodes]
    known[chosen] = base[chosen] + detour > arrival + SLACK * (1 + arrival)
    return (~known).nonzero()[0]


def _relax(
    work: _Relaxation,
    row: IntArray,
    node: IntArray,
    cost: FloatArray,
    base: FloatArray,
    which: IntArray,
    other: IntArray,
) -> tuple[IntArray, IntArray, FloatArray]:
    """Relax connections inside objects. Returns the new pending entries.

    Args:
        work: costs and entries so far, which are changed.
        row: of each entry (k,).
        node: through which the object is entered (k,).
        cost: of getting there (k,).
        base: that with the constant loss of the object (k,).
        which: of the entries (m,), each for a connection.
        other: node at the other end of the connection (m,).
    """
    graph, arrivals, entries = work.graph, work.arrivals, work.entries
    work.relaxed += len(other)
    begin = node[which]
    distance, spread = work.measured(node, which, other)
    candidate = base[which] + work.node_decay[work.table_index(row, node)][which] * distance
    if spread is not None:
        candidate += spread
    if work.special is not None:
        chosen = work.special[begin].nonzero()[0]
        candidate[chosen] = cost[which[chosen]] + np.maximum(
            0.0, intra_costs(graph, begin[chosen], other[chosen])
        )
    place = (row * work.count)[which] + other
    better = (candidate < arrivals[place]).nonzero()[0]
    place = place[better]
    candidate = candidate[better]
    begin = begin[better]
    # Several connections to one node: the cheapest wins, among equal ones that from the lowest
    # entry.
    np.minimum.at(arrivals, place, candidate)
    cheapest = (candidate == arrivals[place]).nonzero()[0]
    if len(cheapest) < len(better):
        better = better[cheapest]
        place = place[cheapest]
        candidate = candidate[cheapest]
        begin = begin[cheapest]
    entries[place] = begin
    first = entries[place] == begin
    if not first.all():
        np.minimum.at(entries, place, begin)
        first = entries[place] == begin
        better = better[first]
        candidate = candidate[first]
    row = row[which[better]]
    other = other[better]
    if work.targets is not None:  # no more than what each of them costs now is of interest
        np.minimum(
            work.limits,
            np.maximum.reduceat(arrivals[work.sought], work.first_sought),
            out=work.limits,
        )
    onwards = candidate + work.crossing[work.table_index(row, other)]
    onto = graph.partner[other]
    place = row * work.count + onto
    go = ((onwards <= work.limits[row]) & (onwards < work.entering[place])).nonzero()[0]
    work.entering[place[go]] = onwards[go]
    return row[go], onto[go], onwards[go]


def _finish_by_dijkstra(work: _Relaxation, row: IntArray, node: IntArray, cost: FloatArray) -> None:
    known: dict[int, _Elements] = {}
    for number in sorted(set(row.tolist())):
        view = work.views[number]
        elements = known[view] = known.get(view) or _Elements(work, view)
        mine = row == number
        arrives = _items(work.arrival[number])
        enters = _items(work.entry[number])
        _dijkstra(
            work,
            elements,
            number,
            list(zip(cost[mine].tolist(), node[mine].tolist(), strict=True)),
            arrives,
            enters,
        )
        work.arrival[number], work.entry[number] = arrives, enters


def _items(array: FloatArray | IntArray) -> Any:
    """An array for access element by element: as a list where it is small, otherwise its buffer;
    indexing either is much faster than indexing the array."""
    return array.tolist() if len(array) <= SMALL else array.data


class _Elements:
    """A graph for access element by element, for Dijkstra's algorithm.

    Attributes:
        points: positions of the nodes; in a large graph, of the objects visited so far.
        laws: how waves spread in the objects visited so far; None where no function spreads.
        fronts: of the nodes whose patches are no points.
        by_table: objects whose costs are not the constant loss plus decay times distance, and are
            computed by the table.
    """

    def __init__(self, work: _Relaxation, view: int) -> None:
        graph = work.graph
        table = work.tables[view]
        self.table = table
        self.objects = _items(graph.node_object)
        self.partner = _items(graph.partner)
        self.start = _items(graph.start)
        self.crossing = _items(work.crossing[view * work.count : (view + 1) * work.count])
        self.loss = _items(np.maximum(0.0, table.loss))
        self.decay = _items(table.decay)
        self.laws: dict[int, Law] | None = None if table.spreading is None else {}
        self.points: dict[int, list[float]] = {}
        self.by_table = graph.table.special
        if graph.reach is not None:
            self.by_table |= set(graph.node_object[graph.reach > 0].tolist())
        self.fronts: dict[int, list[float]] = {}
        if graph.fronts is not None:
            large = graph.fronts[0].nonzero()[0]
            self.fronts.update(zip(large.tolist(), graph.fronts[:, large].T.tolist(), strict=True))
        if work.count <= SMALL:
            self.points.update(enumerate(graph.node_position.tolist()))

    def spread(
        self, index: int, node: int, found: list[tuple[int, float]]
    ) -> list[tuple[int, float]]:
        """The ``found`` nodes and costs in an object with those of spreading from ``node``."""
        assert self.laws is not None
        law = self.laws.get(index)
        if law is None:
            law = self.laws[index] = self.table.objects[index].propagation.spreading_law()
        here, points, distance = self.points[node], self.points, math.dist
        if not self.fronts:
            return [(k, cost + law.cost(distance(here, points[k]))) for k, cost in found]
        own, fronts = self.fronts.get(node, POINT), self.fronts
        return [
            (k, cost + law.between(distance(here, points[k]), own, fronts.get(k, POINT)))
            for k, cost in found
        ]


def _dijkstra(
    work: _Relaxation,
    elements: _Elements,
    row: int,
    queue: list[tuple[float, int]],
    arrives: Any,
    enters: Any,
) -> None:
    """Dijkstra's algorithm for one row.

    Args:
        work: the relaxation, whose limits and targets count.
        elements: its graph, element by element.
        row: number of the row.
        queue: cost and node of the pending entries.
        arrives: cost of arriving at each node, which is changed.
        enters: node through which the object of each node is entered, which is changed.
    """
    graph = work.graph
    heapq.heapify(queue)
    limit = float(work.limits[row])
    objects = elements.objects
    partner = elements.partner
    crossing = elements.crossing
    start = elements.start
    loss = elements.loss
    decay = elements.decay
    special = graph.table.special
    points = elements.points
    sought = set() if work.targets is None else set(work.targets[row].tolist())
    settled: set[int] = set()
    push, pop, distance, infinite = heapq.heappush, heapq.heappop, math.dist, math.inf
    while queue:
        cost, node = pop(queue)
        if cost > limit:
            break
        if node in settled:
            continue
        settled.add(node)
        index = objects[node]
        first = start[index]
        last = start[index + 1]
        base = cost + loss[index]
        rate = decay[index]
        if base == infinite:
            continue
        if arrives[node] <= base and index not in special:
            first = enters[node]
            if not work.complete or partner[first] < 0:
                continue
            last = first + 1
        work.relaxed += last - first
        if index in elements.by_table or last - first >= LARGE:
            nodes = np.arange(first, last)
            begin = np.full(last - first, node)
            constant, varying = elements.table.costs(
                graph.node_object[nodes],
                graph.node_distances(begin, nodes),
                graph.ends(begin, nodes),
            )
            candidate = cost + np.maximum(0.0, constant + varying)
            better = (
                (candidate < np.asarray(arrives[first:last])) & (candidate <= limit)
            ).nonzero()[0]
            found = list(zip((better + first).tolist(), candidate[better].tolist(), strict=True))
        else:
            if node not in points:
                whole = graph.nodes_of(index)
                points.update(enumerate(graph.node_position[whole].tolist(), whole.start))
            here = points[node]
            found = [
                (k, base + rate * distance(here, points[k]))
                for k in range(first, last)
                if arrives[k] > base
            ]
            if elements.laws is not None:
                found = elements.spread(index, node, found)
        nearer = False
        for other, value in found:
            if value < arrives[other] and value <= limit and other != node:
                arrives[other] = value
                enters[other] = node
                through = partner[other]
                if through >= 0:
                    total = value + crossing[other]
                    if total <= limit and total < infinite:
                        push(queue, (total, through))
                elif other in sought:
                    nearer = True
        if nearer:  # stop where no target can get cheaper
            limit = min(limit, max(arrives[k] for k in sought))
