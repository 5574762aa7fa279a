"""`best_path`: the largest product of gains over all paths of a pair, and the path itself."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..graph.haptic_graph import HapticGraph
from ..scene.choices import Strategy
from ..scene.values import Settings
from .connections import (
    HOPS,
    LARGEST,
    SLACK,
    PathConnections,
    bounded_exp,
    cost_limit,
    intra_costs,
    joined,
)
from .hop_constrained import hop_constrained_paths
from .shortest_paths import ShortestPaths, shortest_paths
from .strongest_paths import StrongestPaths

Pair = tuple[int, int]
Path = tuple[int, ...]

COSTS_AT_ONCE = 1 << 22
"""Most pairs of a root and a node whose costs are in memory at a time."""

EXPANSION = 32
"""Work of expanding one partial path in this search, in units of the budget (states)."""


@dataclass(slots=True)
class BestPaths:
    """The best path of each pair of a source (row) and a listener (column), by that pair.

    Attributes:
        nodes: of each best path; pairs without a path are left out.
        cost: of these paths, ``-log(gain)``.
        bands: (p, bands) gains of these paths in each band relative to the plain gain, None without
            bands.
        bound: a lower bound on the cost, for pairs whose path may not be the best one within the
            limits, because the budget ended.
        cut: the most by which the gain may differ from that of the best path without limits, for
            pairs of which the limits may exclude that path.
        visited: largest number of nodes reached from one source or listener.
        relaxed: number of connections evaluated.
        searched: number of partial paths.
    """

    nodes: dict[Pair, Path] = field(default_factory=dict)
    cost: dict[Pair, float] = field(default_factory=dict)
    bands: FloatArray | None = None
    bound: dict[Pair, float] = field(default_factory=dict)
    cut: dict[Pair, float] = field(default_factory=dict)
    visited: int = 0
    relaxed: int = 0
    searched: int = 0


def most_connections(settings: Settings) -> int | None:
    """The limit of connections on a path; `Strategy.AUTO` has none."""
    return None if settings.strategy is Strategy.AUTO else settings.max_connections


def crossings_of(max_connections: int | None) -> float:
    """Contacts that a path may cross: a path over k contacts has 2 k + 1 connections. -1 if not
    even one connection is allowed."""
    return math.inf if max_connections is None else (max_connections - 1) // 2


def crosses_twice(graph: HapticGraph, path: Path) -> bool:
    """True for a walk that crosses a contact more than once."""
    contacts = graph.contact[list(path[1:-1])]  # every contact stands here with both its nodes
    return len(set(contacts.tolist())) * 2 != len(contacts)


def best_paths(
    graph: HapticGraph,
    pairs: IntArray,
    max_connections: int | None,
    threshold: float,
    budget: int,
    amplified: bool,
    known: Mapping[int, tuple[ShortestPaths, int]],
    bands: Mapping[int, int],
) -> BestPaths:
    """The best path of each pair of a source and a listener, with the cost of its plain gains.

    Args:
        graph: the scene.
        pairs: rows of sources and columns of listeners (p, 2).
        max_connections: most connections on a path; None without a limit.
        threshold: least gain of a path.
        budget: bound, per source, on the search for pairs that shortest-path trees do not solve.
        amplified: whether some gain exceeds 1.
        known: shortest-path trees that were computed before, and the row in them, by row of the
            source.
        bands: the frequency band by whose gains a source's paths are chosen. A source without a
            band, and one of whose paths none in that band meets the threshold, has those of the
            plain gains.
    """
    result = BestPaths()
    result.visited = max((trees.visited() for trees, _ in known.values()), default=0)
    crossings = crossings_of(max_connections)
    if amplified and (threshold > 0 or crossings < graph.contact_count):
        result.cut = dict.fromkeys(_keys(pairs[joined(graph, pairs)]), math.inf)
    elif crossings < 0:
        result.cut = dict.fromkeys(_keys(pairs[joined(graph, pairs)]), 1.0)
    if len(pairs) == 0 or crossings < 0:
        return result
    limit = cost_limit(threshold)
    in_band = {band: graph.in_band(band) for band in set(bands.values())}
    views = {
        row: in_band[bands[row]] if row in bands else graph for row in set(pairs[:, 0].tolist())
    }
    longer: dict[Pair, Path] = {}
    weak: list[Pair] = []
    while len(pairs):
        left: list[Pair] = []
        if amplified:
            left += _keys(pairs)
        else:
            found = _unconstrained_paths(_Walks(graph, views, limit), pairs, known, result)
            judged = bool(graph.table.special)
            if judged or crossings < graph.contact_count:
                longest = 2 * crossings + 2
                left += (
                    pair
                    for pair, path in found.items()
                    if len(path) > longest or (judged and crosses_twice(graph, path))
                )
            for pair in left:
                longer.setdefault(pair, found.pop(pair))
            result.nodes |= found
        for row in sorted({row for row, _ in left}):
            _search_from(
                views[row],
                row,
                [column for r, column in left if r == row],
                crossings,
                limit,
                budget,
                amplified,
                result,
            )
        # Bands in which the source is weak may still arrive.
        pairs = np.array(
            [pair for pair in _keys(pairs) if pair not in result.nodes], dtype=np.int64
        ).reshape(-1, 2)
        pairs = pairs[joined(graph, pairs)]
        banded = np.array([views[row] is not graph for row in pairs[:, 0].tolist()], dtype=np.bool_)
        if threshold > 0:
            for pair, by_band in zip(_keys(pairs), banded.tolist(), strict=True):
                if by_band:
                    weak.append(pair)
                else:
                    result.cut.setdefault(pair, threshold)  # of gains above 1, nothing is known
        pairs = pairs[banded]
        views = dict.fromkeys(views, graph)
        known = {}
    _set_costs(graph, result)
    if crossings < graph.contact_count and not amplified:
        _bound_longer(graph, longer, bands, result)
    # Without a threshold, another path would have been chosen, by the band.
    for pair in result.nodes.keys() & weak:
        result.cut[pair] = max(result.cut.get(pair, 0.0), bounded_exp(-result.cost[pair]))
    return result


def _keys(pairs: IntArray) -> list[Pair]:
    return list(map(tuple, pairs.tolist()))


def _bound_longer(
    graph: HapticGraph, longer: Mapping[Pair, Path], bands: Mapping[int, int], result: BestPaths
) -> None:
    """Set ``result.cut`` of the pairs whose best path or cheapest walk without a limit, in
    ``longer``, has more connections than allowed."""
    for (pair, path), cost in zip(
        longer.items(), PathConnections(graph, longer.values()).costs(), strict=True
    ):
        # Of a walk that is no path, only the gain by which it was found bounds those of paths.
        most = 1.0 if pair[0] in bands and crosses_twice(graph, path) else bounded_exp(-cost)
        gain = bounded_exp(-result.cost.get(pair, math.inf))
        if most != gain:
            result.cut[pair] = abs(most - gain)


def _set_costs(graph: HapticGraph, result: BestPaths) -> None:
    """Compute the costs of all paths by the plain gains, and their gains in bands; bounds keep
    their distance from the costs."""
    along = PathConnections(graph, result.nodes.values())
    costs = dict(zip(result.nodes, along.costs(), strict=True))
    for pair in result.bound.keys() & result.nodes.keys():
        result.bound[pair] += costs[pair] - result.cost.get(pair, costs[pair])
    result.cost = costs
    result.bands = along.bands() if graph.uses_bands else None


def _accept(
    graph: HapticGraph, candidates: dict[Pair, Path], limit: float, result: BestPaths
) -> None:
    """Add those ``candidates`` to ``result`` whose cost is within the ``limit``."""
    costs = PathConnections(graph, candidates.values()).costs()
    for (pair, path), cost in zip(candidates.items(), costs, strict=True):
        if cost <= limit and cost < math.inf:
            result.nodes[pair], result.cost[pair] = path, cost


@dataclass(slots=True)
class _Walks:
    """Cheapest walks by pair that meet the threshold; ``views``: the graph by row of the source."""

    graph: HapticGraph
    views: Mapping[int, HapticGraph]
    limit: float
    found: dict[Pair, Path] = field(default_factory=dict)

    def take(
        self,
        trees: ShortestPaths,
        pairs: IntArray,
        tree: IntArray,
        ends: IntArray,
        backwards: BoolArray,
    ) -> None:
        """Take over the walks that meet the threshold.

        Args:
            trees: shortest-path trees.
            pairs: of source and listener (p, 2).
            tree: number of each pair's tree (p,).
            ends: one or two nodes (1 or 2, p), to the nearer of which the walk leads.
            backwards: whether the tree starts at the listener (p,).
        """
        cost = trees.cost[tree, ends].min(axis=0)
        near = (cost <= self.limit + SLACK) & (cost < math.inf)
        if not near.all():
            pairs = pairs[near]
            tree = tree[near]
            ends = ends[:, near]
            cost = cost[near]
            backwards = backwards[near]
        keys = list(map(tuple, pairs.tolist()))
        self.found.update(
            zip(keys, trees.paths(self.graph, tree, ends[0], ends[-1], backwards), strict=True)
        )
        for number in (cost > self.limit - SLACK).nonzero()[0].tolist():
            pair = keys[number]
            if PathConnections(self.views[pair[0]], [self.found[pair]]).costs()[0] > self.limit:
                del self.found[pair]


def _unconstrained_paths(
    walks: _Walks,
    pairs: IntArray,
    known: Mapping[int, tuple[ShortestPaths, int]],
    result: BestPaths,
) -> dict[Pair, Path]:
    """Cheapest walks of the ``pairs`` from shortest-path trees, those ``known`` or new ones."""
    graph, views = walks.graph, walks.views
    for number, (trees, tree) in known.items():
        mine = pairs[pairs[:, 0] == number]
        walks.take(
            trees,
            mine,
            np.full(len(mine), tree),
            graph.listener_nodes[mine[:, 1]][None],
            np.zeros(len(mine), dtype=np.bool_),
        )
    if known:
        pairs = pairs[~np.isin(pairs[:, 0], list(known))]
    if len(pairs) == 0:
        return walks.found
    search = _Trees(graph, views, pairs)
    at_once = max(1, COSTS_AT_ONCE // max(1, graph.node_count))
    parts = range(0, len(search.roots), at_once)
    for first in parts:
        part = slice(first, first + at_once)
        limits = np.full(len(search.roots[part]), walks.limit + SLACK)
        trees = shortest_paths(search.views[part], search.roots[part], limits, search.targets[part])
        result.relaxed += trees.relaxed
        result.visited = max(result.visited, trees.visited())
        here = slice(None) if len(parts) == 1 else search.tree // at_once == first // at_once
        walks.take(
            trees,
            pairs[here],
            search.tree[here] - first,
            search.ends[:, here],
            search.backwards[here],
        )
    return walks.found


def _distinct(numbers: IntArray) -> IntArray:
    """The different ones of some numbers (n,), rising. A few are found faster than by NumPy."""
    return np.array(sorted(set(numbers.tolist())), dtype=np.int64)


class _Trees:
    """The trees that ``pairs`` (p, 2) need: of the sources of each view from themselves or from the
    listeners, whichever are fewer.

    Attributes:
        views, roots, targets: of each tree.
        tree: (p,) number of each pair's tree.
        ends: (2, p) nodes of which the nearer one is the end of the pair's walk in it.
        backwards: (p,) whether the tree starts at the listener.
    """

    def __init__(
        self, graph: HapticGraph, views: Mapping[int, HapticGraph], pairs: IntArray
    ) -> None:
        rows, columns = (_distinct(numbers) for numbers in pairs.T)
        row = rows.searchsorted(pairs[:, 0])
        column = columns.searchsorted(pairs[:, 1])
        nodes = [graph.sources[number].nodes for number in rows.tolist()]
        listeners = graph.listener_nodes[columns]
        starts = np.array([(ends[0], ends[-1]) for ends in nodes]).T
        alike: dict[int, list[int]] = {}
        for place, number in enumerate(rows.tolist()):
            alike.setdefault(id(views[number]), []).append(place)
        self.views: list[HapticGraph] = []
        self.roots: list[tuple[int, ...]] = []
        self.targets: list[IntArray] = []
        first = np.zeros(len(rows), dtype=np.int64)
        backwards = np.zeros(len(rows), dtype=np.bool_)
        for places in alike.values():
            first[places] = len(self.roots)
            if len(places) <= len(columns):
                first[places] += np.arange(len(places))
                roots = [nodes[place] for place in places]
                targets = listeners
            else:
                backwards[places] = True
                roots = [(node,) for node in listeners.tolist()]
                targets = _distinct(starts[:, places].reshape(-1))
            self.roots += roots
            self.targets += [targets] * len(roots)
            self.views += [views[int(rows[places[0]])]] * len(roots)
        self.backwards = backwards[row]
        self.tree = first[row] + np.where(self.backwards, column, 0)
        self.ends = np.where(self.backwards, starts[:, row], listeners[column])


def _search_from(
    graph: HapticGraph,
    row: int,
    columns: Sequence[int],
    crossings: float,
    limit: float,
    budget: int,
    amplified: bool,
    result: BestPaths,
) -> None:
    """Add the best paths from one source to ``result``, by methods that need no assumptions.

    Shortest-path trees fail under a limit of connections and with gains above 1. Here the cheapest
    walk of a limited number of contacts is the best path if it crosses no contact twice; otherwise
    a best-first search finds the path, or bounds its cost when the budget ends.

    Args:
        graph: the scene.
        row: of the source.
        columns: of the listeners.
        crossings: most contacts on a path.
        limit: largest cost of a path.
        budget: bound on the work for all listeners together, in partial paths.
        amplified: whether some gain exceeds 1.
        result: is added to.
    """
    roots = graph.sources[row].nodes
    most = min(crossings, graph.contact_count)
    count = int(min(most, HOPS) if amplified and crossings == math.inf else most)
    walks = hop_constrained_paths(graph, roots, limit + SLACK, count)
    result.relaxed += walks.relaxed
    result.visited = max(result.visited, walks.visited())
    certain = walks.complete or count == most  # more contacts would make no walk cheaper
    share = budget // (EXPANSION * len(columns))
    for column in columns:
        pair = row, column
        target = int(graph.listener_nodes[column])
        path = walks.walk(graph, target)
        if certain and not (path and crosses_twice(graph, path)):
            if path:
                _accept(graph, {pair: path}, limit, result)
            continue
        if not certain:
            ahead = np.full((1, graph.node_count), -amplification(graph))
        else:
            back = hop_constrained_paths(
                graph, (target,), math.inf, len(walks.changes) - 1, complete=True
            )
            result.relaxed += back.relaxed
            ahead = back.costs(graph.node_count)
        search = StrongestPaths(graph, roots, target, ahead, crossings, limit + SLACK, share)
        found = next(search, None)
        result.searched += search.expanded
        if found is not None:
            _accept(graph, {pair: found.nodes}, limit, result)
        elif search.bound < math.inf:
            simple = {
                path
                for k in range(len(walks.changes))
                if (path := walks.walk(graph, target, k)) and not crosses_twice(graph, path)
            }
            ranked = sorted(
                zip(PathConnections(graph, sorted(simple)).costs(), sorted(simple), strict=True)
            )
            if ranked:
                _accept(graph, {pair: ranked[0][1]}, limit, result)
            result.bound[pair] = search.bound


def amplification(graph: HapticGraph) -> float:
    """Logarithm of an upper bound on the gain of any path, which crosses every contact at most
    once, each followed by one intra-connection."""
    inside = np.zeros(len(graph.table.names))
    for index in range(len(inside)):
        nodes = np.arange(graph.start[index], graph.start[index + 1])
        for node in nodes.tolist():
            costs = intra_costs(graph, np.full(len(nodes), node), nodes)
            inside[index] = max(inside[index], -float(np.min(costs[nodes != node], initial=0.0)))
    crossed = np.flatnonzero(graph.partner >= 0)
    beyond = np.zeros(graph.contact_count)
    np.maximum.at(beyond, graph.contact[crossed], inside[graph.node_object[crossed]])
    return float(
        np.max(inside, initial=0.0) + (beyond + np.maximum(0.0, -graph.transmission_loss)).sum()
    )


def gain_and_error(cost: float | None, bound: float | None) -> tuple[float, float]:
    """Gain of a path of this cost (None: no path) and the largest amount by which the best one may
    exceed it, `LARGEST` if that overflows."""
    gain = 0.0 if cost is None else bounded_exp(-cost)
    if gain >= LARGEST:
        return LARGEST, LARGEST
    if bound is None:
        return gain, 0.0
    most = bounded_exp(-bound)
    return gain, max(0.0, most - gain) if most < LARGEST else LARGEST
