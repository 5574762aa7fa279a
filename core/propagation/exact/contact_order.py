"""Which contacts a path can cross, and the order in which the frontier takes them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from ...arrays import IntArray
from ...graph.haptic_graph import HapticGraph

WIDEST = 48
"""Most objects of the frontier that are considered as the next one: where there are more, no order
is narrow enough for an exact sum."""

PAIRINGS = [1.0, 1.0]
"""Number of ways to pair some of 0, 1, 2 ... ends and to leave the others single."""

while len(PAIRINGS) < 200:
    PAIRINGS.append(PAIRINGS[-1] + (len(PAIRINGS) - 1) * PAIRINGS[-2])

Neighbours = dict[int, list[tuple[int, int]]]
"""Of each object: the number of every contact at it, and the object on its other side."""


def contacts_on_paths(
    graph: HapticGraph, roots: Sequence[int], listeners: Sequence[int]
) -> IntArray:
    """The nodes (c, 2) of the contacts that lie on paths from the roots to the listeners.

    Objects are vertices and contacts edges, and a path crosses each edge at most once. With further
    edges from the listeners back to the root, what lies on a path is on a closed trail through the
    root: in its 2-edge-connected component (Menger's theorem). Contacts and objects of gain 0 are
    left out.
    """
    objects = graph.node_object
    nodes = graph.nodes_of_contacts()[graph.transmission > 0]
    nodes = nodes[(graph.table.loss != math.inf)[objects[nodes]].all(axis=1)]
    start, *others = objects[[roots[0], *roots[1:], *roots[1:], *listeners]].tolist()
    back = np.array([(other, start) for other in others if other != start], dtype=np.int64).reshape(
        -1, 2
    )
    inside = np.zeros(len(graph.table.names), dtype=np.bool_)
    inside[
        list(_two_edge_connected(_neighbours(np.concatenate([objects[nodes], back])), start))
    ] = True
    return np.asarray(nodes[inside[objects[nodes]].all(axis=1)])


def _neighbours(ends: IntArray) -> Neighbours:
    """The contacts at each object, given the objects (c, 2) that they join."""
    around: Neighbours = {}
    for number, (one, other) in enumerate(ends.tolist()):
        around.setdefault(one, []).append((number, other))
        around.setdefault(other, []).append((number, one))
    return around


def _two_edge_connected(around: Neighbours, start: int) -> set[int]:
    """The objects that stay connected with ``start`` whichever contact is removed (R. E. Tarjan, "A
    note on finding the bridges of a graph", Information Processing Letters 2, 1974)."""
    number = {start: 0}
    parent = {start: (-1, -1)}
    path = [(start, iter(around.get(start, ())))]
    while path:
        index, ways = path[-1]
        for edge, other in ways:
            if other not in number:
                number[other] = len(number)
                parent[other] = edge, index
                path.append((other, iter(around[other])))
                break
        else:
            path.pop()
    low = dict(number)
    for index in reversed(number):
        for edge, other in around.get(index, ()):
            if edge != parent[index][0]:
                low[index] = min(
                    low[index], low[other] if parent[other][0] == edge else number[other]
                )
    inside = {start}
    for index in number:
        if low[index] < number[index] and parent[index][1] in inside:
            inside.add(index)
    return inside


def contact_order(graph: HapticGraph, contacts: IntArray) -> tuple[IntArray, float]:
    """An order of ``contacts`` (c, 2), given by their nodes, that keeps few ends waiting, and an
    estimate of the frontier's transitions in all.

    Objects are finished one by one, always the one that leaves the fewest ends waiting, beginning
    anywhere, or where that ends. The narrower order is taken.
    """
    around = _neighbours(graph.node_object[contacts])
    if not around:
        return np.arange(0), 0.0
    one = _narrowest(around, next(iter(around)))
    orders = [
        _finished_one_by_one(around, rank) for rank in (one, _narrowest(around, list(one)[-1]))
    ]
    best, transitions = min(orders, key=lambda found: found[1])
    return np.array(best, dtype=np.int64), transitions


def _finished_one_by_one(around: Neighbours, rank: dict[int, int]) -> tuple[list[int], float]:
    """The contacts in the order of the objects at which they end first, and the estimate: as many
    states before each contact as there are ways to pair some of the ends that may wait, each with a
    transition for every two ends that the contact may join."""
    taken = dict.fromkeys(around, 0)
    ends = sorted(
        (rank[one], rank[other], number, one, other)
        for one in around
        for number, other in around[one]
        if rank[one] < rank[other]
    )
    waiting, transitions = 0, 0.0
    for *_, one, other in ends:
        joins = (taken[one] + 1) * (taken[other] + 1)
        transitions += joins * PAIRINGS[min(waiting, len(PAIRINGS) - 1)]
        for index in (one, other):
            before = _may_wait(taken[index], len(around[index]))
            taken[index] += 1
            waiting += _may_wait(taken[index], len(around[index])) - before
    return [number for _, _, number, _, _ in ends], transitions


def _may_wait(done: int, size: int) -> int:
    """Ends that may wait in an object of which ``done`` of ``size`` contacts are taken: each of
    them needs one still to come."""
    return min(done, size - done)


def _narrowest(around: Neighbours, start: int) -> dict[int, int]:
    """The ranks of the objects in an order in which each next one leaves as few ends waiting as
    possible."""
    taken = dict.fromkeys(around, 0)
    rank: dict[int, int] = {}
    frontier = {start: 0}

    def growth(index: int) -> int:
        new = {index: 0}
        for _, other in around[index]:
            if other not in rank:
                new[other] = new.get(other, 0) + 1
        size = {k: len(around[k]) for k in new}
        ahead = sum(
            _may_wait(taken[k] + n, size[k]) - _may_wait(taken[k], size[k]) for k, n in new.items()
        )
        return ahead - _may_wait(taken[index], size[index])

    while frontier:
        some = itertools.islice(frontier, WIDEST)  # in a wider one, no order is narrow
        index = min(some, key=lambda k: (growth(k), frontier[k]))
        del frontier[index]
        rank[index] = len(rank)
        for _, other in around[index]:
            if other not in rank:
                taken[other] += 1
                frontier.setdefault(other, len(rank))
    return rank
