"""The sum over all paths of one 2-edge-connected component, exact or to a tolerance.

Two methods compete: the Simpath programme, exact, whose time grows with the width of the component; and the search that merges partial
paths, which finds most of the sum if gains fall fast along paths, and bounds the rest. Both run alternately with growing parts of the
budget, so that the result costs little more than the better method alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, IntArray
from ...graph.haptic_graph import HapticGraph
from ..connections import LARGEST, intra_lanes, lanes_of
from ..shortest_paths import shortest_paths
from . import simpath
from .bridge_decomposition import Component
from .path_search import ArcRanking, Limits, PathSearch, SearchResult
from .search_graph import SearchGraph, build_search_graph
from .walk_bounds import WalkBounds

STAGES = (1 / 1024, 1 / 256, 1 / 64, 1 / 16, 1 / 4, 1.0)
"""Fractions of the budget for each method in turn, until one of them succeeds."""

NARROW = 4
"""Work allowed to a first attempt with Simpath, as a multiple of the states that its order predicts: enough for a component as narrow as a
wall."""

SLOWER = 0.4
"""Part of the search's share given to Simpath, whose unit of work takes longer; in the last stage it gets the whole share."""

EXPECTED = 60
"""Simpath takes from 1 to 170 times as many transitions as its order predicts, measured on the benchmark's families: if this multiple is
within the budget, it is tried before the search."""

PAIRS = 1 << 22
"""Most pairs of nodes in a search; of a larger component it uses the strongest part, without a bound on the rest."""

ROUNDING = 1e-11
"""Relative allowance for rounding in the bound on a sum that is not exact."""


@dataclass(frozen=True, slots=True)
class ComponentSum:
    """The sum over the paths of a component from its entrance to its exits, over at most ``crossings`` contacts."""

    graph: HapticGraph
    component: Component
    entrance: int
    exits: Sequence[int]
    crossings: float

    @property
    def limited(self) -> bool:
        """Whether the number of contacts on a path is limited."""
        return self.crossings < math.inf

    @property
    def steps(self) -> int:
        """Numbers of crossed contacts that are distinguished."""
        return int(self.crossings) + 1 if self.limited else 1

    def solve(self, tolerance: float, budget: int) -> tuple[FloatArray, FloatArray, int]:
        """Sums (exits, contacts crossed, lanes), bounds (exits,) on what is missing from them, and the work done."""
        simpath_sum = SimpathSum(self)
        exact, spent = simpath_sum.sum(int(min(NARROW * simpath_sum.width, budget * STAGES[-3])))
        if exact is not None:
            return exact, np.zeros(len(self.exits)), spent
        entries, whole = self._entries()
        search_graph = build_search_graph(self.graph, entries, [self.entrance], self.exits)
        bounds = WalkBounds(search_graph, self.crossings, whole)
        known, unknown = np.zeros(len(self.exits)), np.full(len(search_graph.nodes), math.inf)
        best: SearchResult | None = None
        for part in STAGES:
            share = int(budget * part)
            first = part == STAGES[0] or simpath_sum.width * EXPECTED <= share
            for method in ("simpath", "search") if first else ("search", "simpath"):
                if method == "simpath":
                    exact, work = simpath_sum.sum(share if part == STAGES[-1] else int(share * SLOWER))
                    spent += work
                    if exact is not None:
                        return exact, np.zeros(len(self.exits)), spent
                    continue
                # Limited sums and cheap ones are computed exactly.
                accepted = 0.0 if self.limited and part != STAGES[-1] else tolerance
                limits = Limits(self.crossings, 0.0, unknown, 0.0 if first else accepted, known, max(1, share // 4), share)
                found = PathSearch(search_graph, np.ones((1, search_graph.lanes)), limits, bounds, merge=True).run()
                if not whole:
                    found.missing[:] = LARGEST
                spent += found.work
                known = np.maximum(known, found.sums.sum(axis=0)[:, 0])
                if best is None or _better(found, best):
                    best = found
                if np.all(best.missing <= accepted * best.sums.sum(axis=0)[:, 0]):
                    return self._by_count(best), best.missing * (1 + ROUNDING), spent
        assert best is not None
        if np.any(best.missing > best.sums.sum(axis=0)[:, 0]):
            best, work = self._strongest(search_graph, bounds, best, budget)
            spent += work
        return self._by_count(best), best.missing * (1 + ROUNDING), spent

    def _strongest(self, search_graph: SearchGraph, bounds: WalkBounds, best: SearchResult, budget: int) -> tuple[SearchResult, int]:
        """The sum over the strongest paths, as far down as the budget allows, if it is more than ``best``; the upper bound stays."""
        upper = best.sums.sum(axis=0)[:, 0] + best.missing
        ahead = bounds.strongest.max(axis=1)
        threshold = float(ahead[-1])
        ranking = ArcRanking.of(search_graph, ahead)
        spent = 0
        while spent < budget and threshold > 0:
            threshold *= 0.1
            limits = Limits(self.crossings, threshold, ahead, 0.0, np.zeros(len(self.exits)), budget, budget - spent)
            found = PathSearch(search_graph, np.ones((1, search_graph.lanes)), limits, bounds, False, ranking).run()
            spent += found.work
            if found.sums[..., 0].sum() > best.sums[..., 0].sum():
                missing = np.maximum(upper - found.sums.sum(axis=0)[:, 0], 0.0)
                best = SearchResult(found.sums, np.where(upper >= LARGEST, LARGEST, missing), found.paths, found.work)
        return best, spent

    def _by_count(self, found: SearchResult) -> FloatArray:
        sums = np.zeros((len(self.exits), self.steps, lanes_of(self.graph)))
        by_count = found.sums.transpose(1, 0, 2)
        if not self.limited:
            sums[:, 0] = by_count.sum(axis=1)
        else:
            count = min(self.steps, by_count.shape[1])
            sums[:, :count] = by_count[:, :count]
        return sums

    def _entries(self) -> tuple[IntArray, bool]:
        """The contact nodes through which a search enters objects, and whether these are all of them."""
        graph = self.graph
        nodes = np.array([node for patch in self.component.patches for pair in patch for node in pair], dtype=np.int64)
        if self.limited:
            nodes = nodes[self._contacts_needed(nodes) <= self.crossings]
        if _pairs(graph, nodes) <= PAIRS:
            return nodes, True
        limits = np.array([math.inf])
        arrival = shortest_paths(graph, [(self.entrance,)], limits, complete=True).cost[0]
        behind = shortest_paths(graph, [self.exits], limits, complete=True).cost[0]
        cost = arrival[graph.partner[nodes]] + graph.transmission_loss[graph.contact[nodes]] + behind[nodes]
        order = np.lexsort((nodes, cost))
        few, many = 0, len(nodes)
        while many - few > 1 + len(nodes) // 64:
            middle = (few + many) // 2
            few, many = (middle, many) if _pairs(graph, nodes[order[:middle]]) <= PAIRS else (few, middle)
        return nodes[order[:few]], False

    def _contacts_needed(self, nodes: IntArray) -> IntArray:
        """The fewest contacts of any walk from the entrance to an exit that enters an object through each node."""
        objects, partner = self.graph.node_object, self.graph.partner
        pairs = list(zip(objects[nodes].tolist(), objects[partner[nodes]].tolist(), strict=True))
        ways: dict[int, list[int]] = {}
        for a, b in pairs:
            ways.setdefault(a, []).append(b)
        before = simpath.hops(ways, [int(objects[self.entrance])])
        behind = simpath.hops(ways, [int(objects[node]) for node in self.exits])
        far = len(nodes)
        return np.array([1 + before.get(b, far) + behind.get(a, far) for a, b in pairs], dtype=np.int64)


def _pairs(graph: HapticGraph, nodes: IntArray) -> int:
    """Pairs of these nodes that are in one object."""
    sizes = np.bincount(graph.node_object[nodes])
    return int((sizes * sizes).sum())


def _better(found: SearchResult, best: SearchResult) -> bool:
    """Whether the bound on the missing part is smaller, or, without bounds, the sum is larger."""
    if np.max(found.missing, initial=0.0) >= LARGEST:
        return bool(found.sums[..., 0].sum() > best.sums[..., 0].sum())
    return bool(found.missing.sum() <= best.missing.sum())


class SimpathSum:
    """The Simpath programme of a component, prepared once for several attempts."""

    def __init__(self, problem: ComponentSum) -> None:
        self.problem = problem
        self.graph = problem.graph
        self.lanes = lanes_of(self.graph)
        self.exits = np.array(problem.exits, dtype=np.int64)
        component, entrance = problem.component, problem.entrance
        objects, position = self.graph.node_object, self.graph.node_position
        edges = [(int(objects[patch[0][0]]), int(objects[patch[0][1]])) for patch in component.patches]
        places = {
            index: position[a].tolist() for patch in component.patches for a, b in patch for index in (int(objects[a]), int(objects[b]))
        }
        start = int(objects[entrance])
        order, self.expected = simpath.order_patches(edges, places, start)
        ordered = [[(int(objects[a]), a, int(objects[b]), b) for a, b in component.patches[number]] for number in order]
        self.width = self.expected[-1] if self.expected else 0.0
        try:
            self.crossings = simpath.plan(ordered, (start, entrance))
        except simpath.TooWide:
            self.crossings, self.width = [], math.inf
        self.running: simpath.SumOverPaths | None = None

    def _ends(self, nodes: IntArray) -> list[FloatArray | None]:
        """Of each node: the factors (exits, lanes) of ending at the exits, or None where there are none in its object."""
        objects = self.graph.node_object
        inside = (objects[nodes][:, None] == objects[self.exits]) & (nodes[:, None] != self.exits)
        which, number = np.nonzero(inside)
        table = np.zeros((*inside.shape, self.lanes))
        table[which, number] = intra_lanes(self.graph, nodes[which], self.exits[number])
        return [row if some else None for row, some in zip(table, inside.any(axis=1).tolist(), strict=True)]

    def _weigh(self) -> list[simpath.Weights]:
        """The factors of all crossings, computed together."""
        graph = self.graph
        sides = [(node, waiting) for crossing in self.crossings for node, waiting in zip(crossing.nodes, crossing.waiting, strict=True)]
        sizes = [len(waiting) for _, waiting in sides]
        nodes = np.array([node for node, _ in sides], dtype=np.int64)
        others = np.array([node for _, waiting in sides for node, _ in waiting], dtype=np.int64)
        joins = intra_lanes(graph, np.repeat(nodes, sizes), others)
        ends = self._ends(nodes)
        contact = graph.contact[nodes[::2]]
        through = np.repeat(graph.transmission[contact][:, None], self.lanes, axis=1)
        if graph.contact_band_gains is not None:
            through[:, 1:] *= graph.contact_band_gains[contact]
        alone = np.ones((1, self.lanes))
        weights = []
        place = 0
        for number in range(len(self.crossings)):
            size_a, size_b = sizes[2 * number : 2 * number + 2]
            by_a = np.concatenate([joins[place : place + size_a], alone]) * through[number]
            by_b = np.concatenate([joins[place + size_a : place + size_a + size_b], alone])
            place += size_a + size_b
            weights.append(simpath.Weights(by_a[:, None] * by_b, (by_a, by_b * through[number]), (ends[2 * number], ends[2 * number + 1])))
        return weights

    def sum(self, allowed: int) -> tuple[FloatArray | None, int]:
        """Sums (exits, contacts crossed, lanes), or None where ``allowed`` work in all is not enough; and the work done by this call."""
        if self.width > allowed:
            return None, 0
        with np.errstate(over="ignore", invalid="ignore"):
            if self.running is None:
                self.running = self._begin()
            before = self.running.work
            total = self.running.run(allowed)
        # Overflow: the search reports such a sum as a lower bound.
        found = total if total is not None and np.all(total <= LARGEST) else None
        return found, int(self.running.work - before)

    def _begin(self) -> simpath.SumOverPaths:
        problem = self.problem
        start = np.zeros((problem.steps, self.lanes))
        start[0] = 1.0
        (ends,) = self._ends(np.array([problem.entrance]))
        at_start = np.zeros((len(self.exits), self.lanes)) if ends is None else ends
        return simpath.SumOverPaths(self.crossings, self._weigh(), start, at_start, problem.limited, self.expected)
