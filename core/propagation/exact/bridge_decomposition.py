"""Bridge decomposition of the contacts: a sum over paths is a product over 2-edge-connected components.

Objects are the vertices and contact patches the edges of a multigraph, and a path crosses each edge at most once (it may enter an object
again). It crosses a *bridge* (an edge whose removal disconnects the graph) at most once, and the sum over all paths factorises
over the components between bridges. A part beyond a bridge without a listener is a dead end and is removed. Inside a 2-edge-connected
component every patch is on some path, by Menger's theorem.

Source: R. E. Tarjan, "A note on finding the bridges of a graph", Information Processing Letters 2, 1974.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from ...arrays import IntArray, connected
from ...graph.haptic_graph import HapticGraph


@dataclass(slots=True)
class Component:
    """A 2-edge-connected component: objects that stay connected whichever patch is removed.

    Attributes:
        first: an object through which it is entered.
        objects: its objects.
        patches: the patches inside, each a tuple of the (node, node) pairs of its contacts.
        listeners: listener nodes in it.
        bridges: each a tuple of (node here, node beyond) pairs, and the component beyond.
    """

    first: int
    objects: list[int] = field(default_factory=list)
    patches: list[tuple[tuple[int, int], ...]] = field(default_factory=list)
    listeners: list[int] = field(default_factory=list)
    bridges: list[tuple[tuple[tuple[int, int], ...], Component]] = field(default_factory=list)


def decompose(graph: HapticGraph, root: int, listeners: Iterable[int]) -> Component | None:
    """The bridge tree, as the component that node ``root`` belongs to with everything beyond it that leads to a listener.

    None if nothing leads to a listener. Contacts and objects of gain 0 are left out.
    """
    heard: dict[int, list[int]] = {}
    for node in listeners:
        heard.setdefault(int(graph.node_object[node]), []).append(node)
    edges, neighbours = _edges(graph)
    start = int(graph.node_object[root])
    order, leader = _two_edge_connected(start, neighbours)
    made: dict[int, Component] = {}
    for index in order:
        component = made.setdefault(leader[index], Component(first=index))
        component.objects.append(index)
        component.listeners += heard.get(index, ())
    seen: set[int] = set()
    bridges: list[tuple[Component, Component, tuple[tuple[int, int], ...]]] = []
    for index in order:
        for edge, other in neighbours[index]:
            if edge in seen:
                continue
            seen.add(edge)
            nodes = edges[edge]
            if leader[index] == leader[other]:
                made[leader[index]].patches.append(nodes)
            else:  # a bridge; `index` was found first, so it is on the root's side
                here = nodes if graph.node_object[nodes[0][0]] == index else tuple((b, a) for a, b in nodes)
                bridges.append((made[leader[index]], made[leader[other]], here))
    for before, beyond, nodes in reversed(bridges):  # the farthest first
        if beyond.listeners or beyond.bridges:
            before.bridges.append((nodes, beyond))
    root_component = made[leader[start]]
    root_component.first = start
    return root_component if root_component.listeners or root_component.bridges else None


def is_forest(graph: HapticGraph, entries: IntArray) -> bool:
    """Whether the contacts that lead into ``entries`` close no cycle of objects: then at most one path joins any two nodes."""
    first = entries[np.unique(graph.contact[entries], return_index=True)[1]]
    count = len(graph.table.names)
    trees = np.unique(connected(graph.node_object[np.column_stack([first, graph.partner[first]])], count))
    return len(trees) == count - len(first)


def _edges(graph: HapticGraph) -> tuple[dict[int, tuple[tuple[int, int], ...]], dict[int, list[tuple[int, int]]]]:
    """Contacts of each patch as (node, node) pairs, and (patch, neighbour) of each object."""
    blocked = graph.table.loss == np.inf
    first = np.flatnonzero(graph.partner > np.arange(graph.node_count))
    contact = graph.contact[first]
    a, b = graph.node_object[first], graph.node_object[graph.partner[first]]
    open_ = (graph.transmission[contact] > 0) & ~blocked[a] & ~blocked[b]
    first, contact, a, b = first[open_], contact[open_], a[open_], b[open_]
    edges: dict[int, tuple[tuple[int, int], ...]] = {}
    neighbours: dict[int, list[tuple[int, int]]] = {}
    for number, node, partner, one, other in zip(
        contact.tolist(), first.tolist(), graph.partner[first].tolist(), a.tolist(), b.tolist(), strict=True
    ):
        edges[number] = ((node, partner),)
        neighbours.setdefault(one, []).append((number, other))
        neighbours.setdefault(other, []).append((number, one))
    return edges, neighbours


def _two_edge_connected(start: int, neighbours: dict[int, list[tuple[int, int]]]) -> tuple[list[int], dict[int, int]]:
    """Objects in depth-first order, and for each the first object of its 2-edge-connected component (Tarjan)."""
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
