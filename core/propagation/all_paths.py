"""The sum of the gains of all paths."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..graph import HapticGraph
from .connections import ROUNDING
from .labels import label

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def enumerate_paths(
    graph: HapticGraph, sources: tuple[int, ...], listeners: list[int], max_connections: int | None, threshold: float
) -> tuple[FloatArray, IntArray]:
    """Sum of gains and number of paths from the source's nodes to each listener, one path after the other."""
    sums = np.zeros(len(listeners))
    counts = np.zeros(len(listeners), dtype=np.int64)
    if not listeners:
        return sums, counts
    ahead = np.exp(np.negative(label(graph, [listeners], np.array([math.inf]), complete=True).arrival[0]))
    by_object: dict[int, list[int]] = {}
    for number, node in enumerate(listeners):
        by_object.setdefault(int(graph.node_object[node]), []).append(number)
    limit = math.inf if max_connections is None else max_connections
    least = threshold * (1 - ROUNDING)
    patch = patches(graph)
    for source in sources:
        stack = [(source, 1.0, 1, frozenset[int]())]
        while stack:
            node, gain, connections, crossed = stack.pop()
            if connections > limit:
                continue
            index = int(graph.node_object[node])
            nodes = graph.nodes_of(index)
            gains = gain * graph.intra_gain(index, node, nodes)
            for number in by_object.get(index, ()):
                total = float(gains[listeners[number] - nodes.start])
                if total > 0 and total >= least:
                    sums[number] += total
                    counts[number] += 1
            for other in range(nodes.start, nodes.stop):
                partner = int(graph.partner[other])
                contact = int(graph.contact[other])
                if partner < 0 or other == node or patch[contact] in crossed:
                    continue
                total = float(gains[other - nodes.start] * graph.transmission[contact] * graph.share[contact])
                if total > 0 and total * ahead[partner] >= least:
                    stack.append((partner, total, connections + 2, crossed | {int(patch[contact])}))
    return sums, counts


def patches(graph: HapticGraph) -> IntArray:
    """Number of the patch of each contact: contacts of one pair of objects with a share below 1 are points of one patch."""
    patch = np.arange(graph.contact_count)
    first: dict[tuple[int, int], int] = {}
    for contact in np.flatnonzero(graph.share < 1).tolist():
        a, b = np.flatnonzero(graph.contact == contact).tolist()
        patch[contact] = first.setdefault((int(graph.node_object[a]), int(graph.node_object[b])), contact)
    return patch

