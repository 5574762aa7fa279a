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

Where waves spread, more entries drop out, those of a ground on which bodies conduct better than
itself. Let E(x) be less than A(x) - a. It can lower the cost of y only if the detour ``m(e, x) +
m(x, y) - m(e, y)`` is less than ``A(x) - a - E(x)``. As m is a concave function of distance, the
detour grows with the distance from x to y, and is least where x lies between e and y. Where even
that of a node as near as the nearest one is too long, x drops out.

Where few connections are examined at a time, as along a chain, a heap of entries is faster than
arrays.

Where some bodies move and all else stands still, paths that cross none of their contacts cost what
they did, and stay the best if no way through these contacts makes any other node nearer: then the
trees of an earlier graph are those of this one. What lies behind these contacts is found anew from
what does not.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from copy import copy

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, portions, ranges
from ..frozen import frozen
from ..graph.haptic_graph import HapticGraph
from .spacing import spacing

LIMIT = math.log(1e6)
"""Cost at which the search ends: -120 dB."""

BATCH = 1 << 15
"""Connections examined at a time: enough to outweigh the overhead, few enough that later entries
gain from earlier ones, and that arrays stay in the cache."""

PER_ENTRY = 4
"""Connections that take as long as going through an entry that stays pending."""

TINY = 2000
"""With up to so many connections in all rows the heap is faster from the beginning."""

SPARSE = 300
"""Once the steps so far have examined fewer connections each on average, and the graph has no more
than so many for each step, the heap is faster."""

SLACK = 1e-9
"""Relative error of costs that is far above that of rounding."""


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
        search: what found them.
    """

    cost: FloatArray
    entry: IntArray
    cut: BoolArray
    examined: int
    search: _Search


def shortest_paths(
    graph: HapticGraph,
    roots: Sequence[Sequence[int]],
    bands: Sequence[int] | None = None,
    targets: Sequence[IntArray] | None = None,
    backwards: bool = False,
    limit: float = LIMIT,
    known: ShortestPaths | None = None,
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
        known: those of an earlier graph, which are returned, or mended, if their paths to the
            targets are then surely the shortest.
    """
    search = _Search(graph, roots, bands, targets, backwards, limit)
    if (
        known is not None
        and 4 * known.examined > max(BATCH, known.entry.size)  # else a search is as fast
        and search.is_like(known.search)
        and (found := copy(search).mended(known)) is not None
    ):
        return found
    row, node = search.roots
    pending = row, node, np.zeros(len(node))
    connections = int((search.size - 1).sum())
    steps = 0
    while len(pending[0]):
        is_sparse = max(search.examined, connections) < SPARSE * steps
        if is_sparse or len(roots) * connections <= TINY:
            search.one_by_one(*pending)
            break
        now, later = search.cheapest(*pending)
        pending = _merged([later, *(search.across(*search.inside(*part)) for part in now)])
        steps += 1
    return search.result()


Entries = tuple[IntArray, IntArray, FloatArray]
"""Row, node and cost (k,) of entries: an object is entered through the node at that cost."""


def _merged(parts: Sequence[Entries]) -> Entries:
    """The entries of all parts."""
    several = [part for part in parts if len(part[0])]
    if len(several) < 2:
        return (several or parts)[0]
    row, node, cost = (np.concatenate(values) for values in zip(*several, strict=True))
    return row, node, cost


class _Search:
    """State of the search: the costs and entries so far.

    Arrays that depend on the frequency band hold those of one band after the other; ``lane`` says
    where those of a row begin.
    """

    def __init__(
        self,
        graph: HapticGraph,
        roots: Sequence[Sequence[int]],
        bands: Sequence[int] | None,
        targets: Sequence[IntArray] | None,
        backwards: bool,
        limit: float,
    ) -> None:
        self.graph, self.count = graph, graph.node_count
        rows = len(roots)
        self.asked = roots, bands, [nodes.tolist() for nodes in targets or ()], backwards, limit
        self.roots = (
            np.arange(rows).repeat([len(nodes) for nodes in roots]),
            np.concatenate([np.array(nodes, dtype=np.int64) for nodes in roots]),
        )
        self.limit = min(limit, 1e300)
        self.limits = np.full(rows, self.limit)
        self.cut = np.zeros(rows, dtype=np.bool_)
        # A cost begins just above the limit, so that a path beyond the limit is no improvement.
        self.arrival = np.full(rows * self.count, np.nextafter(self.limit, math.inf))
        self.entering = np.full(rows * self.count, math.inf)  # least cost of entering at each node
        self.entry = np.full(rows * self.count, -1, dtype=np.int64)
        used = sorted(set(bands or ()))
        views = [graph.in_band(band) for band in used] or [graph]
        index = graph.node_object
        self.loss = np.concatenate([view.table.loss[index] for view in views])
        self.decay = np.concatenate([view.table.decay[index] for view in views])
        self.crossing = np.concatenate([view.crossing_costs(backwards) for view in views])
        self.lane = np.array([used.index(band) for band in bands or ()] or [0] * rows)
        self.first = graph.start[index]  # of each node's object the first node, and their number
        self.size = graph.start[index + 1] - self.first
        self.special = np.zeros(len(graph.table.names), dtype=np.bool_)
        self.special[list(graph.table.special)] = True
        self.targets = targets
        self.spacing: FloatArray | None = None  # made when it is worth it
        self.sought = np.zeros(0, dtype=np.int64)
        if targets is not None:
            size = np.array([len(nodes) for nodes in targets])
            self.sought = np.concatenate(targets)
            self.sought += (np.arange(rows) * self.count).repeat(size)
            self.first_sought = size.cumsum() - size
        self.is_vast = bool((np.abs(graph.node_position) > 1e150).any())
        self.examined = 0
        self.due = 0.0

    def distances(self, begin: IntArray, other: IntArray) -> FloatArray:
        """`HapticGraph.node_distances`, but 0 below 1e-154 m, whose square is 0."""
        if self.is_vast:
            return self.graph.node_distances(begin, other)
        x, y, z = (places[begin] - places[other] for places in self.graph.node_position.T)
        apart: FloatArray = np.sqrt(x * x + y * y + z * z)
        reach = self.graph.reach
        return apart if reach is None else np.maximum(apart - (reach[begin] + reach[other]), 0.0)

    def cheapest(
        self, row: IntArray, node: IntArray, cost: FloatArray
    ) -> tuple[list[Entries], Entries]:
        """The cheapest of the pending entries, as many as a step examines, in portions, and the
        others. Those that improve nothing drop out."""
        graph = self.graph
        place = row * self.count + node
        base = cost + self.loss[self.lane[row] * self.count + node]
        useful = self.arrival[place] > base
        if graph.table.special:
            useful |= self.special[graph.node_object[node]] | self._returns(place)
        # Others have become cheaper since, or are of no interest any more.
        useful &= (cost <= self.entering[place]) & (cost <= self.limits[row])
        kept = useful.nonzero()[0]
        row, node, cost = row[kept], node[kept], cost[kept]
        work = self.size[node].cumsum()
        if len(work) and work[-1] > BATCH and not graph.table.special:
            kept = self._improving(row, node, base[kept])
            row, node, cost = row[kept], node[kept], cost[kept]
            work = self.size[node].cumsum()
        later = row[:0], node[:0], cost[:0]
        if len(work) == 0:
            return [], later
        # More than are pending, or going through these each time would take longer than the steps.
        most = max(BATCH, PER_ENTRY * len(work))
        if work[-1] > most:
            order = cost.argsort(kind="stable")
            row, node, cost = row[order], node[order], cost[order]
            work = self.size[node].cumsum()
            count = max(1, int(work.searchsorted(most, side="right")))
            later = row[count:], node[count:], cost[count:]
            work = work[:count]
        now = [(row[part], node[part], cost[part]) for part in portions(work, BATCH)]
        return now, later

    def _improving(self, row: IntArray, node: IntArray, base: FloatArray) -> IntArray:
        """Numbers of those entries that may lower costs in their object, given by row, node, and
        cost with the constant loss of the object (k,)."""
        graph = self.graph
        spreading = graph.table.spreading
        if spreading is None or self.is_vast:
            return np.arange(len(row))
        if self.spacing is None:
            self.spacing = spacing(graph)
        place = row * self.count + node
        before = self.entry[place]
        known = (before >= 0) & (self.spacing[node] > 0)
        if graph.fronts is not None:
            run = graph.fronts[0]
            known &= (run[node] == 0) & (run[before] == 0)
        chosen = known.nonzero()[0]
        nodes = node[chosen]
        detour = spreading.detour(
            graph.node_object[nodes], self.distances(before[chosen], nodes), self.spacing[nodes]
        )
        arrival = self.arrival[place[chosen]]
        known[chosen] = base[chosen] + detour > arrival + SLACK * (1 + arrival)
        return np.asarray((~known).nonzero()[0])

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
        size, other = self.others(node)
        candidate = self.costs(self.lane[row], node, size, other)
        candidate += cost.repeat(size)
        self.examined += len(other)
        begin = node.repeat(size)
        place = (row * self.count).repeat(size)
        place += other
        beyond = candidate > self.limit
        if beyond.any():
            self.cut[place[beyond] // self.count] = True
        better = (candidate < self.arrival[place]).nonzero()[0]
        place, begin, candidate = place[better], begin[better], candidate[better]
        # Several connections to one node: the cheapest wins, among equal ones the first, as if they
        # were in different portions.
        np.minimum.at(self.arrival, place, candidate)
        cheapest = (candidate == self.arrival[place]).nonzero()[0]
        place, begin, candidate = place[cheapest], begin[cheapest], candidate[cheapest]
        self.entry[place[::-1]] = begin[::-1]
        if (self.entry[place] != begin).any():
            first = (self.entry[place] == begin).nonzero()[0]
            place, candidate = place[first], candidate[first]
        row, node = np.divmod(place, self.count)
        return row, node, candidate

    def others(self, node: IntArray) -> tuple[IntArray, IntArray]:
        """Of nodes (k,) the numbers (k,) of other nodes of their objects, and these (m,)."""
        size = self.size[node] - 1
        other = ranges(self.first[node], size)
        other += other >= node.repeat(size)
        return size, other

    def costs(
        self, lane: IntArray | int, node: IntArray, size: IntArray, other: IntArray
    ) -> FloatArray:
        """Costs (m,) of the connections from nodes (k,), of each in its ``lane``, to `others`."""
        graph = self.graph
        place = lane * self.count + node
        begin = node.repeat(size)
        distance = self.distances(begin, other)
        cost: FloatArray = self.decay[place].repeat(size)
        cost *= distance
        cost += self.loss[place].repeat(size)
        if graph.table.spreading is not None:
            index = graph.node_object[node].repeat(size)
            cost += graph.table.spreading.cost(index, distance, graph.ends(begin, other))
        for number in graph.table.special:
            chosen = (graph.node_object[node] == number).repeat(size)
            with np.errstate(divide="ignore"):
                cost[chosen] = -np.log(graph.table.gain(number, distance[chosen]))
        return cost

    def one_by_one(self, row: IntArray, node: IntArray, cost: FloatArray) -> None:
        """Go on from the pending entries one after the other, with a heap, to the end."""
        graph = self.graph
        every = np.arange(self.count)
        size, other = self.others(every)
        others, partner = other.tolist(), graph.partner.tolist()
        first = [0, *size.cumsum().tolist()]
        inside: dict[int, list[float]] = {}
        for number in sorted(set(row.tolist())):
            lane = int(self.lane[number])
            if lane not in inside:
                inside[lane] = self.costs(lane, every, size, other).tolist()
            mine = row == number
            part = slice(number * self.count, (number + 1) * self.count)
            arrival, entry = self.arrival[part].tolist(), self.entry[part].tolist()
            part = slice(lane * self.count, (lane + 1) * self.count)
            crossing, loss = self.crossing[part].tolist(), self.loss[part].tolist()
            sought = set() if self.targets is None else set(self.targets[number].tolist())
            limit = float(self.limits[number])
            queue = sorted(zip(cost[mine].tolist(), node[mine].tolist(), strict=True))
            settled: set[int] = set()
            cut = False
            while queue and queue[0][0] <= limit:
                near, begin = heapq.heappop(queue)
                useful = arrival[begin] > near + loss[begin] or graph.table.special
                if begin in settled or not useful:
                    continue
                settled.add(begin)
                connections = range(first[begin], first[begin + 1])
                self.examined += len(connections)
                is_nearer = False
                for connection in connections:
                    end, far = others[connection], near + inside[lane][connection]
                    if far < arrival[end]:
                        arrival[end], entry[end] = far, begin
                        is_nearer |= end in sought
                        far += crossing[end]
                        if far <= limit:
                            heapq.heappush(queue, (far, partner[end]))
                    cut = cut or (far > limit and (partner[end] >= 0 or end in sought))
                if is_nearer:  # no more than what each target costs now is of interest
                    limit = min(limit, max(arrival[k] for k in sought))
            part = slice(number * self.count, (number + 1) * self.count)
            self.arrival[part], self.entry[part] = arrival, entry
            self.cut[number] |= cut
            self.limits[number] = limit

    def across(self, row: IntArray, node: IntArray, cost: FloatArray) -> Entries:
        """Go on from nodes over their contacts. Returns the new entries."""
        # No more than what each target costs now is of interest. Many are asked more rarely.
        if len(self.sought) and self.examined >= self.due:
            self.due = self.examined + len(self.sought)
            dearest = np.maximum.reduceat(self.arrival[self.sought], self.first_sought)
            np.minimum(self.limits, dearest, out=self.limits)
        cost = cost + self.crossing[self.lane[row] * self.count + node]
        node = self.graph.partner[node]
        beyond = (cost > self.limit) & (node >= 0)
        if beyond.any():
            self.cut[row[beyond]] = True
        place = row * self.count + node
        go = ((cost <= self.limits[row]) & (cost < self.entering[place])).nonzero()[0]
        row, node, cost = row[go], node[go], cost[go]
        self.entering[place[go]] = cost
        return row, node, cost

    def result(self) -> ShortestPaths:
        self.arrival[self.entry < 0] = math.inf
        shape = len(self.limits), self.count
        return ShortestPaths(
            self.arrival.reshape(shape), self.entry.reshape(shape), self.cut, self.examined, self
        )

    def is_like(self, old: _Search) -> bool:
        """Whether an earlier search was asked the same, with the same bodies touching, and its
        roots lay where they do."""
        graph, roots = self.graph, self.roots[1]
        return (
            graph.partner is old.graph.partner
            and not graph.table.special
            and self.asked == old.asked
            and np.array_equal(graph.node_position[roots], old.graph.node_position[roots])
        )

    def mended(self, known: ShortestPaths) -> ShortestPaths | None:
        """The trees of an earlier search that `is_like` this one, if their paths to the targets are
        surely those that this one would find. Where it lost targets, what it lost is found anew.
        None where that is not sure."""
        graph, old, rows = self.graph, known.search, len(self.limits)
        over = np.where(graph.partner >= 0, graph.partner, np.arange(self.count))
        lost = self._lost(old, over)
        row, node = lost.nonzero()
        if self.size[node].sum() > lost.size:  # as long as a search
            return None
        # What is not lost costs what it did.
        self.limits, self.cut, self.due = old.limits, old.cut.copy(), math.inf
        arrival = old.arrival.reshape(rows, -1)
        entering = (arrival + self.crossing.reshape(-1, self.count)[self.lane]).take(over, axis=1)
        entering[lost] = math.inf
        entering[self.roots] = 0.0
        self.entering = entering.reshape(-1)
        size, other = self.others(node)
        cost = self.costs(self.lane[row], node, size, other)
        place = (row * self.count).repeat(size) + other
        number = np.arange(len(node)).repeat(size)

        def nearest() -> FloatArray:
            least = np.full(len(node), math.inf)
            np.minimum.at(least, number, cost + self.entering[place])
            return least

        least = nearest()
        arrival = np.minimum(arrival, self.limits[:, None])  # what costs more is of no interest
        arrival[row, node] = least
        self.arrival = (arrival + SLACK * (1 + arrival)).reshape(-1)
        pending = self.across(row, node, least)
        while len(pending[0]):
            now, later = self.cheapest(*pending)
            onwards = [later]
            for part in now:
                better, end, far = self.inside(*part)
                if not lost[better, end].all():
                    return None
                onwards.append(self.across(better, end, far))
            pending = _merged(onwards)
        lost = lost.reshape(-1)
        if not lost[self.sought].any():
            return known
        least = nearest()
        least[least > self.limits[row]] = math.nan
        near = cost + self.entering[place] <= (least + SLACK * (1 + least)).repeat(size)
        found = number[near]
        self.arrival, self.entry = old.arrival.copy(), old.entry.copy()
        place = row * self.count + node
        self.arrival[place], self.entry[place] = least, -1
        self.entry[place[found]] = other[near]
        gone = (lost & (self.entry < 0))[self.sought]
        # Of several ways that cost the same a search chooses one; it goes on beyond these limits.
        if (
            not np.diff(found).all()
            or (self.limits[self.sought[gone] // self.count] < self.limit).any()
        ):
            return None
        self.examined = known.examined
        return self.result()

    def _lost(self, known: _Search, over: IntArray) -> BoolArray:
        """Nodes (r, n) whose costs an earlier search does not tell: their contacts have changed, or
        those on the way to them. ``over`` (n,): the node across the contact of each, or itself."""
        graph, old = self.graph, known.graph
        lost = (self.crossing != known.crossing).reshape(-1, self.count)[self.lane]
        lost |= (graph.node_position.T != old.node_position.T).any(axis=0)
        lost |= np.any(graph.fronts != old.fronts, axis=0)
        lost |= graph.reach != old.reach
        entry = known.entry.reshape(lost.shape)
        before = over[entry] + self.count * np.arange(len(lost))[:, None]
        count = -1
        while count < (count := int(np.count_nonzero(lost))):
            lost |= lost.take(over, axis=1)
            lost |= lost.take(before) & (entry >= 0)
        return np.asarray(lost)
