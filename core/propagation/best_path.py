"""`best_path`: the path of the largest product of gains of each pair of a source and a listener."""

from __future__ import annotations

import numpy as np

from ..arrays import BoolArray, IntArray
from ..frozen import frozen
from ..graph.haptic_graph import HapticGraph
from .paths import Paths
from .shortest_paths import LIMIT, ShortestPaths, shortest_paths

COSTS_AT_ONCE = 1 << 22
"""Most pairs of a root and a node whose costs are in memory at a time."""

Kept = dict[bool, ShortestPaths]
"""The trees of the last graph, by bands and plain ones."""


@frozen
class BestPaths:
    """The best ``paths``, the most nodes ``visited`` from one root, and the number of connections
    ``examined``."""

    paths: Paths
    visited: int = 0
    examined: int = 0


def best_paths(
    graph: HapticGraph, wanted: BoolArray, limit: float = LIMIT, kept: Kept | None = None
) -> BestPaths:
    """The best paths of the ``wanted`` (s, l) pairs of a source and a listener, by the gains of
    each source's leading band, or by the plain ones where that band does not arrive; pairs without
    a path of at most the cost ``limit`` are left out."""
    kept = {} if kept is None else kept
    found, weak = _searched(graph, np.argwhere(wanted), True, limit, kept)
    if not graph.uses_bands or len(weak) == 0:
        return found
    more, _ = _searched(graph, weak, False, limit, kept)
    return BestPaths(
        Paths.joined([found.paths, more.paths]),
        max(found.visited, more.visited),
        found.examined + more.examined,
    )


def _searched(
    graph: HapticGraph, pairs: IntArray, by_band: bool, limit: float, kept: Kept
) -> tuple[BestPaths, IntArray]:
    """The best paths of ``pairs`` (p, 2), and those pairs of which the limit may have ended all
    paths.

    Trees grow from the sources, or, where these are more than the listeners, from the listeners,
    once for each band.
    """
    if len(pairs) == 0:
        return BestPaths(Paths.none()), pairs
    row, column = pairs.T
    ends = np.array([(source.nodes[0], source.nodes[-1]) for source in graph.sources])
    band = np.array([source.band if by_band else 0 for source in graph.sources])
    from_listeners = _numbered(band[row] * len(graph.listeners) + column)
    from_sources = _numbered(row)
    backwards = bool(from_sources.max() > from_listeners.max())
    tree = from_listeners if backwards else from_sources
    first = np.zeros(tree.max() + 1, dtype=np.int64)
    first[tree] = np.arange(len(tree))  # a pair of each tree
    start, target = ends[row], graph.listener_nodes[column][:, None]
    if backwards:
        start, target = target, start
    at_once = max(1, COSTS_AT_ONCE // graph.node_count)
    found, weak, visited, examined = [], [], 0, 0
    for begin in range(0, len(first), at_once):
        here = ((tree >= begin) & (tree < begin + at_once)).nonzero()[0]
        mine = first[begin : begin + at_once]
        own, goal = tree[here] - begin, target[here]
        trees = kept[by_band] = shortest_paths(
            graph,
            [sorted(set(nodes)) for nodes in start[mine].tolist()],
            band[row[mine]].tolist() if by_band else None,
            _targets(own, goal),
            backwards,
            limit,
            kept.get(by_band),
        )
        nearest = trees.cost[own[:, None], goal].argmin(axis=1)
        node = goal[np.arange(len(goal)), nearest]
        there = trees.entry[own, node] >= 0
        weak.append(pairs[here[~there & trees.cut[own]]])
        here, own, node = here[there], own[there], node[there]
        found.append(_walked(graph, trees, pairs[here], own, node, backwards))
        visited = max(visited, int((trees.entry >= 0).sum(axis=1).max()))
        examined += trees.examined
    return BestPaths(Paths.joined(found), visited, examined), np.concatenate(weak)


def _numbered(values: IntArray) -> IntArray:
    """The number of each of these ``values`` (n,), from 0 on, among those that occur."""
    occurs = np.zeros(values.max() + 1, dtype=np.bool_)
    occurs[values] = True
    return np.asarray((occurs.cumsum() - 1)[values])


def _targets(tree: IntArray, target: IntArray) -> list[IntArray]:
    """The nodes that each tree shall reach, from the ``target`` (p, 1 or 2) nodes of pairs."""
    order = tree.argsort(kind="stable")
    cuts = tree[order].searchsorted(np.arange(1, tree.max() + 1))
    return [nodes.reshape(-1) for nodes in np.split(target[order], cuts)]


def _walked(
    graph: HapticGraph,
    trees: ShortestPaths,
    pairs: IntArray,
    tree: IntArray,
    node: IntArray,
    backwards: bool,
) -> Paths:
    """The paths, from source to listener, of ``pairs`` (p, 2), which end at a ``node`` (p,) of
    their trees (p,)."""
    steps = []
    while (node >= 0).any():
        begin = np.where(node >= 0, trees.entry[tree, node], -1)
        steps += [node, begin]
        node = np.where(begin >= 0, graph.partner[begin], -1)
    if not steps:
        return Paths.none()
    nodes = np.stack(steps if backwards else steps[::-1], axis=1)
    inside = nodes >= 0
    return Paths(pairs, nodes[inside], inside.sum(axis=1).cumsum())
