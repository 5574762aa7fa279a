"""The haptic graph with every connection as an edge."""

import networkx
import numpy as np


def explicit_graph(graph):
    """A graph of NetworkX with every connection of a haptic graph as an edge in either direction.

    Nodes carry ``object``, ``kind``, ``position``; edges ``connection`` ("intra" or "inter") and
    ``gain``.
    """
    explicit = networkx.DiGraph()
    kinds = {node: "source" for source in graph.sources for node in source.nodes}
    kinds |= dict.fromkeys(graph.listener_nodes.tolist(), "listener")
    for node in range(graph.node_count):
        explicit.add_node(
            node,
            object=graph.table.names[graph.node_object[node]],
            kind=kinds.get(node, "contact"),
            position=tuple(graph.node_position[node].tolist()),
        )
    for index in range(len(graph.table.names)):
        nodes = graph.nodes_of(index)
        a, b = (side + nodes.start for side in np.triu_indices(nodes.stop - nodes.start, 1))
        gains = graph.table.gains(
            graph.node_object[a], graph.node_distances(a, b), graph.ends(a, b)
        )
        for node, other, gain in zip(a.tolist(), b.tolist(), gains.tolist(), strict=True):
            explicit.add_edge(node, other, connection="intra", gain=gain)
            explicit.add_edge(other, node, connection="intra", gain=gain)
    gains = np.exp(-graph.crossing_costs())
    for node in (graph.partner >= 0).nonzero()[0].tolist():
        explicit.add_edge(
            node, int(graph.partner[node]), connection="inter", gain=float(gains[node])
        )
    return explicit
