"""Sums over paths: of those whose gain stays at a threshold or above by breadth-first search, of all by the bridge tree."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...graph.haptic_graph import HapticGraph
from ..connections import HOPS, LARGEST, SLACK, PathConnections, cost_limit, lanes_of
from ..hop_constrained import hop_constrained_paths
from ..shortest_paths import ShortestPaths, shortest_paths
from .bridge_decomposition import is_forest
from .bridge_tree_sums import PathLimits, PathSums, bridge_tree_sums
from .component_sums import ROUNDING
from .path_search import ArcRanking, Limits, PathSearch, SearchResult
from .search_graph import SearchGraph, build_search_graph
from .walk_bounds import WalkBounds

LONG = 64
"""Limit of contacts on a path above which a forest is not searched: its paths are taken from the trees of shortest paths."""


@dataclass(frozen=True, slots=True)
class ThresholdCosts:
    """Shortest paths up to a threshold. ``forward``: those of each source (a row); ``behind`` (n,): least cost from entering at a node to
    any listener."""

    forward: ShortestPaths
    behind: FloatArray


def threshold_costs(graph: HapticGraph, sources: Sequence[Sequence[int]], threshold: float) -> ThresholdCosts:
    """Costs from the nodes of each source and from all listeners together, up to the threshold. No gain may exceed 1."""
    limit = cost_limit(threshold) + SLACK
    trees = shortest_paths(graph, [*sources, graph.listener_nodes.tolist()], np.full(len(sources) + 1, limit), complete=True)
    return ThresholdCosts(ShortestPaths(trees.cost[:-1], trees.entry[:-1], trees.relaxed), trees.cost[-1])


def sum_over_paths(
    graph: HapticGraph,
    roots: Sequence[int],
    listeners: Sequence[int],
    limits: PathLimits,
    known: tuple[ThresholdCosts, int] | None = None,
    recrossings: bool = False,
) -> PathSums:
    """Sum of the products of gains over the paths from the nodes ``roots`` of a source to each of the nodes ``listeners``.

    With a threshold, whether a path counts depends on its own gain, so paths are searched one by one, as arrays. Without one, the sum
    factorises over the bridges of the contacts, and inside a component it is found without enumeration (`bridge_tree_sums`). The result is
    exact, or an interval: a lower bound that was summed, and a bound on the rest.

    Args:
        known: costs up to the threshold and the source's row in them; None if some gain exceeds 1.
        recrossings: whether the result includes the walks that were stopped because they cross a contact twice.
    """
    if limits.threshold == 0:
        return bridge_tree_sums(graph, roots, listeners, limits)
    limit = cost_limit(limits.threshold) + SLACK
    if known is None:
        most = int(min(limits.crossings, graph.contact_count))
        reached = hop_constrained_paths(graph, roots, limit, min(most, HOPS), complete=True)
        certain = reached.complete or most <= HOPS
        arrival = reached.costs(graph.node_count)[-1] if certain else np.zeros(graph.node_count)
        behind = np.zeros(graph.node_count)
    else:
        arrival, behind = known[0].forward.cost[known[1]], known[0].behind
    before = arrival[graph.partner] + np.append(graph.transmission_loss, math.inf)[graph.contact]
    before[list(roots)] = 0.0
    entries = np.flatnonzero((graph.partner >= 0) & (before + behind <= limit))
    if known is not None and len(roots) == 1 and limits.crossings > LONG and is_forest(graph, entries):
        return _only_paths(graph, listeners, known[0].forward, known[1], limit)
    search_graph = build_search_graph(graph, entries, roots, listeners, (before, behind, limit))
    ahead = np.full(len(search_graph.nodes), math.inf) if known is None else np.exp(-behind[search_graph.nodes])
    found = _search(search_graph, limits, ahead, len(roots), recrossings)
    sums = np.minimum(found.sums.sum(axis=0), LARGEST)
    error = np.minimum(found.missing * (1 + ROUNDING), LARGEST)
    recrossed = None if found.recrossed is None else (search_graph.nodes, found.recrossed)
    return PathSums(sums, error, found.paths, found.work, recrossed)


def _search(search_graph: SearchGraph, limits: PathLimits, ahead: FloatArray, roots: int, recrossings: bool) -> SearchResult:
    """The search for the exact sum and, where that leaves out more than the tolerance, one that drops partial paths of little weight."""
    bounds, ranking = WalkBounds(search_graph, limits.crossings), ArcRanking.of(search_graph, ahead)

    def found(tolerance: float, known: FloatArray) -> SearchResult:
        states = max(1, limits.budget // 4)
        chosen = Limits(limits.crossings, limits.threshold, ahead, tolerance, known, states, limits.budget)
        return PathSearch(search_graph, np.ones((roots, search_graph.lanes)), chosen, bounds, False, ranking, recrossings).run()

    exact = found(0.0, np.zeros(search_graph.listeners))
    sums = exact.sums.sum(axis=0)[:, 0]
    if np.all(exact.missing <= limits.tolerance * sums) or np.any(bounds.sums(0)[-roots:] >= LARGEST):
        return exact
    tolerant = found(limits.tolerance, sums)
    return tolerant if tolerant.missing.sum() < exact.missing.sum() else exact


def _only_paths(graph: HapticGraph, listeners: Sequence[int], forward: ShortestPaths, row: int, limit: float) -> PathSums:
    """The sums in a forest of contacts, where the best path to a listener is the only one."""
    sums = PathSums(np.zeros((len(listeners), lanes_of(graph))), np.zeros(len(listeners)), np.zeros(len(listeners), dtype=np.int64), 0)
    nodes = np.array(listeners, dtype=np.int64)
    rows, backwards = np.full(len(nodes), row), np.zeros(len(nodes), dtype=np.bool_)
    paths = {number: path for number, path in enumerate(forward.paths(graph, rows, nodes, nodes, backwards)) if path}
    along = PathConnections(graph, paths.values())
    for number, cost, bands in zip(paths, along.costs(), along.bands(), strict=True):
        if cost <= limit - SLACK:
            sums.gain[number, 0] = math.exp(-cost)
            sums.gain[number, 1:] = math.exp(-cost) * bands[: lanes_of(graph) - 1]
            sums.paths[number] = 1
    return sums
