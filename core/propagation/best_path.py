"""`best_path`: the largest product of gains over all paths of a pair, and the path itself."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..graph.haptic_graph import HapticGraph
from ..scene.choices import Strategy
from ..scene.values import Settings
from .connections import LARGEST, SLACK, bounded_exp, cost_limit, intra_costs, path_costs
from .hop_constrained import HopConstrainedPaths, hop_constrained_paths
from .shortest_paths import ShortestPaths, shortest_paths
from .strongest_paths import StrongestPaths

Pair = tuple[int, int]
Path = tuple[int, ...]

COSTS_AT_ONCE = 1 << 22
"""Most pairs of a root and a node whose costs are held at a time, a bound on memory."""

EXPANSION = 32
"""Work of one partial path of this search, in the states that a budget counts."""

HOPS_UNLIMITED = 64
"""Most contacts on the walks that are searched by hops where gains exceed 1 and nothing limits the connections."""


@dataclass(slots=True)
class BestPaths:
    """Per pair (row of the source, column of the listener): the nodes of its best path, and its cost ``-log(gain)``. Pairs without a path
    are left out. ``bound`` holds, where it is not certain that the path is the best, a cost that no path falls below. ``visited`` nodes of
    the graph, the most for any one source or listener; ``relaxed`` connections looked at, and ``searched`` partial paths."""

    nodes: dict[Pair, Path] = field(default_factory=dict)
    cost: dict[Pair, float] = field(default_factory=dict)
    bound: dict[Pair, float] = field(default_factory=dict)
    visited: int = 0
    relaxed: int = 0
    searched: int = 0


def most_connections(settings: Settings) -> int | None:
    """The limit of connections on a path; `Strategy.AUTO` has none."""
    return None if settings.strategy is Strategy.AUTO else settings.max_connections


def crossings_of(max_connections: int | None) -> float:
    """Contacts that a path may cross: a path over k contacts has 2 k + 1 connections. -1 where not even one connection is allowed."""
    return math.inf if max_connections is None else (max_connections - 1) // 2


def crosses_twice(graph: HapticGraph, path: Path) -> bool:
    """True for a walk that crosses a contact more than once."""
    contacts = graph.contact[list(path[1:-1])]  # every contact stands here with both its nodes
    return len(set(contacts.tolist())) * 2 != len(contacts)


def best_paths(
    graph: HapticGraph,
    pairs: Iterable[Pair],
    max_connections: int | None,
    threshold: float,
    budget: int,
    amplified: bool,
    known: Mapping[int, tuple[ShortestPaths, int]],
    bands: Mapping[int, int] | None = None,
) -> BestPaths:
    """The best path of each pair. ``budget`` bounds the search that is needed where shortest-path trees are not enough, per source.
    ``amplified``: some gain exceeds 1. ``known``: trees that are known already, and the row in them, by row of the source. ``bands``: the
    frequency band by whose gains a source's paths are chosen; the plain gain where it has none, and where nothing meets the threshold by
    that band. Costs are those of the plain gains."""
    result = BestPaths()
    wanted = sorted(pairs)
    result.visited = max((trees.visited() for trees, _ in known.values()), default=0)
    crossings = crossings_of(max_connections)
    if not wanted or crossings < 0:
        return result
    limit = cost_limit(threshold)
    in_band = {band: graph.in_band(band) for band in set((bands or {}).values())}
    views = {row: in_band[(bands or {})[row]] if row in (bands or {}) else graph for row, _ in wanted}
    if amplified:
        left = wanted
    else:
        candidates = _unconstrained_paths(graph, views, [pair for pair in wanted if pair[0] not in known], limit, result)
        for row, (trees, number) in known.items():
            columns = [column for other, column in wanted if other == row]
            paths = trees.paths(graph, [(number, (node,)) for node in graph.listener_nodes[columns].tolist()])
            candidates.update({(row, column): path for column, path in zip(columns, paths, strict=True) if path})
        judged = bool(graph.table.special)
        left = [pair for pair, path in candidates.items() if len(path) > 2 * crossings + 2 or (judged and crosses_twice(graph, path))]
        for pair in left:
            del candidates[pair]
        for view in {id(view): view for view in views.values()}.values():
            _accept(view, {pair: path for pair, path in candidates.items() if views[pair[0]] is view}, limit, result)
    for row in sorted({row for row, _ in left}):
        _search_row(views[row], row, [column for r, column in left if r == row], crossings, limit, budget, amplified, result)
    judged_anew = [pair for pair in result.nodes if pair[0] in (bands or {})]
    for pair, cost in zip(judged_anew, path_costs(graph, [result.nodes[pair] for pair in judged_anew]), strict=True):
        if pair in result.bound:  # as far below as it was
            result.bound[pair] += cost - result.cost[pair]
        result.cost[pair] = cost
    missing = [pair for pair in wanted if pair[0] in (bands or {}) and pair not in result.nodes]
    if missing:  # lower frequencies, in which the source is weak, may still arrive
        plain = best_paths(graph, missing, max_connections, threshold, budget, amplified, {})
        result.nodes |= plain.nodes
        result.cost |= plain.cost
        result.bound |= plain.bound
        result.visited = max(result.visited, plain.visited)
        result.relaxed, result.searched = result.relaxed + plain.relaxed, result.searched + plain.searched
    return result


def _accept(graph: HapticGraph, candidates: dict[Pair, Path], limit: float, result: BestPaths) -> None:
    """Take over the paths that meet the threshold."""
    for (pair, path), cost in zip(candidates.items(), path_costs(graph, list(candidates.values())), strict=True):
        if cost <= limit and cost < math.inf:
            result.nodes[pair], result.cost[pair] = path, cost


def _unconstrained_paths(
    graph: HapticGraph, views: Mapping[int, HapticGraph], wanted: Sequence[Pair], limit: float, result: BestPaths
) -> dict[Pair, Path]:
    """Cheapest walks by trees, from the side that has fewer nodes; ``views``: the graph by row of the source. A tree from a listener is for
    sources of one view."""
    if not wanted:
        return {}
    rows, columns = sorted({row for row, _ in wanted}), sorted({column for _, column in wanted})
    listener_nodes = graph.listener_nodes.tolist()
    alike = {id(views[row]): views[row] for row in rows}
    forward = len(rows) <= len(columns) * len(alike)
    if forward:
        starts = [(row, views[row]) for row in rows]
        roots, targets = [graph.sources[row].nodes for row in rows], [listener_nodes[column] for column in columns]
    else:
        starts = [(column, view) for view in alike.values() for column in columns]
        roots, targets = [(listener_nodes[column],) for column, _ in starts], [node for row in rows for node in graph.sources[row].nodes]
    target_nodes = np.array(sorted(set(targets)), dtype=np.int64)
    at_once = max(1, COSTS_AT_ONCE // max(1, graph.node_count))
    found: dict[Pair, Path] = {}
    for first in range(0, len(roots), at_once):
        part = roots[first : first + at_once]
        trees = shortest_paths([view for _, view in starts[first : first + at_once]], part, np.full(len(part), limit + SLACK), target_nodes)
        result.relaxed += trees.relaxed
        result.visited = max(result.visited, trees.visited())
        numbers = {(start, id(view)): number for number, (start, view) in enumerate(starts[first : first + at_once])}
        pairs = [pair for pair in wanted if (pair[0 if forward else 1], id(views[pair[0]])) in numbers]
        ways: list[tuple[int, tuple[int, ...]]] = [
            (numbers[row, id(views[row])], (listener_nodes[column],))
            if forward
            else (numbers[column, id(views[row])], graph.sources[row].nodes)
            for row, column in pairs
        ]
        for pair, path in zip(pairs, trees.paths(graph, ways), strict=True):
            if path:
                found[pair] = path if forward else path[::-1]
    return found


def _search_row(
    graph: HapticGraph, row: int, columns: Sequence[int], crossings: float, limit: float, budget: int, amplified: bool, result: BestPaths
) -> None:
    """Best paths of one source where shortest-path trees are not enough: hop-constrained walks; where such a walk is no path, a search."""
    roots = graph.sources[row].nodes
    most = min(crossings, graph.contact_count)
    count = int(min(most, HOPS_UNLIMITED) if amplified and crossings == math.inf else most)
    walks = hop_constrained_paths(graph, roots, limit + SLACK, count)
    result.relaxed += walks.relaxed
    result.visited = max(result.visited, walks.visited())
    certain = walks.complete or count == most
    share = budget // (EXPANSION * len(columns))
    for column in columns:
        target = int(graph.listener_nodes[column])
        path = walks.walk(graph, target)
        if path and certain and not crosses_twice(graph, path):
            _accept(graph, {(row, column): path}, limit, result)
        elif path or not certain:
            _search_pair(graph, (row, column), walks, crossings, limit, share, certain, result)


def _search_pair(
    graph: HapticGraph,
    pair: Pair,
    walks: HopConstrainedPaths,
    crossings: float,
    limit: float,
    budget: int,
    certain: bool,
    result: BestPaths,
) -> None:
    target = int(graph.listener_nodes[pair[1]])
    if certain:
        back = hop_constrained_paths(graph, (target,), math.inf, len(walks.changes) - 1, complete=True)
        result.relaxed += back.relaxed
        ahead = back.costs(graph.node_count)
    else:
        ahead = np.full((1, graph.node_count), -amplification(graph))
    search = StrongestPaths(graph, graph.sources[pair[0]].nodes, target, ahead, crossings, limit + SLACK, budget)
    found = next(search, None)
    result.searched += search.expanded
    if found is not None:
        _accept(graph, {pair: found.nodes}, limit, result)
    elif search.bound < math.inf:
        simple = {path for k in range(len(walks.changes)) if (path := walks.walk(graph, target, k)) and not crosses_twice(graph, path)}
        ranked = sorted(zip(path_costs(graph, sorted(simple)), sorted(simple), strict=True))
        if ranked:
            _accept(graph, {pair: ranked[0][1]}, limit, result)
        result.bound[pair] = search.bound


def amplification(graph: HapticGraph) -> float:
    """Logarithm of a gain that no path exceeds: it crosses every contact at most once, and each one leads into one intra-connection."""
    inside = np.zeros(len(graph.table.names))
    for index in range(len(inside)):
        nodes = np.arange(graph.start[index], graph.start[index + 1])
        for node in nodes.tolist():
            costs = intra_costs(graph, np.full(len(nodes), node), nodes)
            inside[index] = max(inside[index], -float(np.min(costs[nodes != node], initial=0.0)))
    crossed = np.flatnonzero(graph.partner >= 0)
    beyond = np.zeros(graph.contact_count)
    np.maximum.at(beyond, graph.contact[crossed], inside[graph.node_object[crossed]])
    return float(np.max(inside, initial=0.0) + (beyond + np.maximum(0.0, -graph.transmission_loss)).sum())


def gain_and_error(cost: float | None, bound: float | None) -> tuple[float, float]:
    """Gain of a path of this cost (None: no path) and how far the best one may exceed it, `LARGEST` where no number says it."""
    gain = 0.0 if cost is None else bounded_exp(-cost)
    if gain >= LARGEST:
        return LARGEST, LARGEST
    if bound is None:
        return gain, 0.0
    most = bounded_exp(-bound)
    return gain, max(0.0, most - gain) if most < LARGEST else LARGEST
