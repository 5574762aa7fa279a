"""Peers on the same contacts: NetworkX, SciPy and rustworkx on the explicit graph, and plain
breadth-first enumeration.

Each takes the arrays of a `Family`, as `haptic_tracing` does, and is timed with everything that it
has to build from them.
"""

from __future__ import annotations

import math
import time
from collections import deque
from dataclasses import dataclass

import numpy as np
from haptic_tracing.core.graph.haptic_graph import HapticGraph

from .families import Family

FREE = 1e-300
"""Cost that stands for 0, which in a sparse matrix means no connection."""


def explicit_connections(graph: HapticGraph) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Both ends and the cost of every connection, intra-connections of an object in one vectorised
    step."""
    ends_a, ends_b, costs = [], [], []
    for index in range(len(graph.table.names)):
        nodes = graph.nodes_of(index)
        count = nodes.stop - nodes.start
        if count > 1:
            a, b = np.triu_indices(count, 1)
            position = graph.node_position[nodes]
            distance = np.sqrt(np.square(position[a] - position[b]).sum(axis=1))
            ends_a.append(a + nodes.start)
            ends_b.append(b + nodes.start)
            costs.append(graph.table.loss[index] + graph.table.decay[index] * distance)
    first = np.flatnonzero(graph.partner > np.arange(graph.node_count))
    ends_a.append(first)
    ends_b.append(graph.partner[first])
    costs.append(graph.crossing_costs()[first])
    return np.concatenate(ends_a), np.concatenate(ends_b), np.maximum(np.concatenate(costs), FREE)


def by_scipy(family: Family) -> np.ndarray:
    """Gains (sources, listeners)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    graph = family.graph()
    a, b, cost = explicit_connections(graph)
    matrix = coo_array((cost, (a, b)), shape=(graph.node_count, graph.node_count)).tocsr()
    found = dijkstra(matrix, directed=False, indices=[source.nodes[0] for source in graph.sources])
    return np.asarray(np.exp(-found[:, graph.listener_nodes]))


def by_networkx(family: Family) -> np.ndarray:
    """Gains (sources, listeners)."""
    import networkx

    graph = family.graph()
    explicit = networkx.Graph()
    explicit.add_nodes_from(range(graph.node_count))
    explicit.add_weighted_edges_from(
        zip(*(array.tolist() for array in explicit_connections(graph)), strict=True)
    )
    gains = np.zeros((len(graph.sources), len(graph.listeners)))
    for row, source in enumerate(graph.sources):
        costs = networkx.single_source_dijkstra_path_length(explicit, source.nodes[0])
        gains[row] = [
            math.exp(-costs.get(node, math.inf)) for node in graph.listener_nodes.tolist()
        ]
    return gains


def by_rustworkx(family: Family) -> np.ndarray:
    """Gains (sources, listeners)."""
    import rustworkx

    graph = family.graph()
    explicit = rustworkx.PyGraph(multigraph=False)
    explicit.add_nodes_from(range(graph.node_count))
    explicit.add_edges_from(
        list(zip(*(array.tolist() for array in explicit_connections(graph)), strict=True))
    )
    gains = np.zeros((len(graph.sources), len(graph.listeners)))
    for row, source in enumerate(graph.sources):
        root = source.nodes[0]
        costs = rustworkx.dijkstra_shortest_path_lengths(explicit, root, float)
        gains[row] = [
            1.0 if node == root else math.exp(-costs[node]) if node in costs else 0.0
            for node in graph.listener_nodes.tolist()
        ]
    return gains


PEERS = {"NetworkX": by_networkx, "SciPy": by_scipy, "rustworkx": by_rustworkx}


class OutOfTime(Exception):
    """An enumeration took longer than allowed."""


@dataclass(frozen=True, slots=True)
class Enumeration:
    """Gains (listeners,) and how many partial paths were followed."""

    gains: np.ndarray
    followed: int


def enumerate_paths(
    family: Family, max_connections: int | None, threshold: float, seconds: float
) -> Enumeration:
    """Breadth-first propagation as in the paper: a queue of partial paths, each taken one
    connection of either kind further until it is at a listener, at ``max_connections``, or below
    the ``threshold``. Raises OutOfTime after so many ``seconds``."""
    end = time.process_time() + seconds
    graph = family.graph()
    inside: list[list[tuple[int, float]]] = []
    for node in range(graph.node_count):
        index = int(graph.node_object[node])
        nodes = graph.nodes_of(index)
        others = np.arange(nodes.start, nodes.stop)
        gains = graph.table.gain(
            index, graph.node_distances(np.full(len(others), node), others)
        ).tolist()
        inside.append(
            [
                (other, gain)
                for other, gain in zip(range(nodes.start, nodes.stop), gains, strict=True)
                if other != node
            ]
        )
    partner, contact = graph.partner.tolist(), graph.contact.tolist()
    through = np.exp(-graph.crossing_costs()).tolist()
    listener = {node: column for column, node in enumerate(graph.listener_nodes.tolist())}
    sums = [0.0] * len(listener)
    most = math.inf if max_connections is None else max_connections
    followed = 0
    (root,) = graph.sources[0].nodes
    # Where it has just entered, gain, contacts crossed (a bit each), connections.
    queue = deque([(root, 1.0, 0, 0)])
    while queue:
        node, gain, crossed, connections = queue.popleft()
        followed += 1
        if followed & 1023 == 0 and time.process_time() > end:
            raise OutOfTime
        if connections >= most:
            continue
        for other, factor in inside[node]:
            arrived = gain * factor
            if arrived < threshold:
                continue
            if partner[other] < 0:
                if other in listener:
                    sums[listener[other]] += arrived
                continue
            bit = 1 << contact[other]
            onwards = arrived * through[other]
            if not crossed & bit and onwards >= threshold and onwards > 0:
                queue.append((partner[other], onwards, crossed | bit, connections + 2))
    return Enumeration(np.array(sums), followed)
