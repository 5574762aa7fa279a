"""Where a sum over paths falls apart: bridges and the pieces between them.

Objects are the vertices and patches of contact the edges of a multigraph, and a path crosses each edge at most once (it may come back to
an object). So it crosses a *bridge* (an edge whose removal parts the graph) once, in one direction, and the sum over all paths is a
product over the pieces between bridges. What lies behind a bridge and holds no listener is a dead end and drops out. Inside a piece (a
2-edge-connected component) every patch is on some path, by Menger's theorem.

Source: R. E. Tarjan, "A note on finding the bridges of a graph", Information Processing Letters 2, 1974.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from ...arrays import IntArray
from ...graph.haptic_graph import HapticGraph


@dataclass(slots=True)
class Piece:
    """Objects that stay connected whichever patch is removed.

    ``patches``: those inside, each a tuple of (node, node) pairs: its contacts. ``listeners``: listener nodes in it. ``bridges``: ways on,
    each a tuple of (node here, node beyond) pairs and the piece beyond. ``first`` an object through which it is entered.
    """

    first: int
    objects: list[int] = field(default_factory=list)
    patches: list[tuple[tuple[int, int], ...]] = field(default_factory=list)
    listeners: list[int] = field(default_factory=list)
    bridges: list[tuple[tuple[tuple[int, int], ...], Piece]] = field(default_factory=list)


def patches_of(graph: HapticGraph) -> IntArray:
    """Patch number of each contact (c,).

    Contacts of one pair of objects with a share below 1 are points of one patch, which a path crosses once, by one of its points. With that
    a patch weighs the same however many points it is refined to; were its points crossed like contacts of their own, the way in by one and
    out by the next would be new paths, and refining would add to the sum.
    """
    patch = np.arange(graph.contact_count)
    first_nodes = np.flatnonzero(graph.partner > np.arange(graph.node_count))
    parts = first_nodes[graph.share[graph.contact[first_nodes]] < 1]
    if len(parts):
        pair = np.column_stack([graph.node_object[parts], graph.node_object[graph.partner[parts]]])
        _, first, which = np.unique(pair, axis=0, return_index=True, return_inverse=True)
        patch[graph.contact[parts]] = graph.contact[parts[first]][which.reshape(-1)]
    return patch


def pieces(graph: HapticGraph, root: int, listeners: Iterable[int]) -> Piece | None:
    """The piece of the object that node ``root`` belongs to, with everything behind it that leads to a listener; None where nothing does.

    A contact that transmits nothing, or an object that lets nothing through, is not there.
    """
    heard: dict[int, list[int]] = {}
    for node in listeners:
        heard.setdefault(int(graph.node_object[node]), []).append(node)
    edges, neighbours = _edges(graph)
    start = int(graph.node_object[root])
    order, component = _components(start, neighbours)
    made: dict[int, Piece] = {}
    for index in order:
        piece = made.setdefault(component[index], Piece(first=index))
        piece.objects.append(index)
        piece.listeners += heard.get(index, ())
    seen: set[int] = set()
    ways: list[tuple[Piece, Piece, tuple[tuple[int, int], ...]]] = []
    for index in order:
        for edge, other in neighbours[index]:
            if edge in seen:
                continue
            seen.add(edge)
            nodes = edges[edge]
            if component[index] == component[other]:
                made[component[index]].patches.append(nodes)
            else:  # a bridge; `index` was found first, so it is the side of the root
                here = nodes if graph.node_object[nodes[0][0]] == index else tuple((b, a) for a, b in nodes)
                ways.append((made[component[index]], made[component[other]], here))
    for before, behind, nodes in reversed(ways):  # the farthest first
        if behind.listeners or behind.bridges:
            before.bridges.append((nodes, behind))
    root_piece = made[component[start]]
    root_piece.first = start
    return root_piece if root_piece.listeners or root_piece.bridges else None


def acyclic(graph: HapticGraph, entries: IntArray, patch: IntArray) -> bool:
    """Whether the patches that lead into ``entries`` form no cycle of objects: then there is one way at most between any two nodes."""
    joined: dict[int, int] = {}

    def representative(index: int) -> int:
        while (above := joined.setdefault(index, index)) != index:
            joined[index] = joined[above]
            index = above
        return index

    there = graph.node_object[graph.partner[entries]].tolist()
    ends = dict(zip(patch[graph.contact[entries]].tolist(), zip(graph.node_object[entries].tolist(), there, strict=True), strict=True))
    for one, other in ends.values():
        a, b = representative(one), representative(other)
        if a == b:
            return False
        joined[a] = b
    return True


def _edges(graph: HapticGraph) -> tuple[dict[int, tuple[tuple[int, int], ...]], dict[int, list[tuple[int, int]]]]:
    """Contacts of each patch as (node, node) pairs, and (patch, neighbour) of each object."""
    blocked = graph.table.loss == np.inf
    first = np.flatnonzero(graph.partner > np.arange(graph.node_count))
    contact = graph.contact[first]
    a, b = graph.node_object[first], graph.node_object[graph.partner[first]]
    open_ = (graph.transmission[contact] > 0) & (graph.share[contact] > 0) & ~blocked[a] & ~blocked[b]
    first, contact, a, b = first[open_], contact[open_], a[open_], b[open_]
    patch = patches_of(graph)[contact] if np.any(graph.share < 1) else contact
    edges: dict[int, tuple[tuple[int, int], ...]] = {}
    neighbours: dict[int, list[tuple[int, int]]] = {}
    for number, node, partner, one, other in zip(
        patch.tolist(), first.tolist(), graph.partner[first].tolist(), a.tolist(), b.tolist(), strict=True
    ):
        if number in edges:
            edges[number] += ((node, partner),)
            continue
        edges[number] = ((node, partner),)
        neighbours.setdefault(one, []).append((number, other))
        neighbours.setdefault(other, []).append((number, one))
    return edges, neighbours


def _components(start: int, neighbours: dict[int, list[tuple[int, int]]]) -> tuple[list[int], dict[int, int]]:
    """Objects in depth-first order, and the 2-edge-connected component of each (named by its first object)."""
    number = {start: 0}
    low = {start: 0}
    order = [start]
    parent_edge = {start: -1}
    component: dict[int, int] = {}
    unassigned = [start]
    neighbours.setdefault(start, [])
    path = [(start, iter(neighbours[start]))]
    while path:
        index, ways = path[-1]
        for edge, other in ways:
            if edge == parent_edge[index]:
                continue
            if other in number:
                low[index] = min(low[index], number[other])
                continue
            number[other] = low[other] = len(order)
            order.append(other)
            parent_edge[other] = edge
            unassigned.append(other)
            path.append((other, iter(neighbours[other])))
            break
        else:
            path.pop()
            if path:
                before = path[-1][0]
                low[before] = min(low[before], low[index])
            if low[index] == number[index]:
                while True:
                    member = unassigned.pop()
                    component[member] = index
                    if member == index:
                        break
    return order, component
