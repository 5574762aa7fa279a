"""Statistical energy analysis on the haptic graph."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..graph import HapticGraph

FloatArray = NDArray[np.float64]


def energy_gains(graph: HapticGraph) -> FloatArray:
    """Amplitude gains (s, l): the square root of the energy at the listener's object per unit of power of the source."""
    count = len(graph.table.names)
    crossing = np.array([_mean_gain(graph, index) for index in range(count)])
    active = crossing > 0
    matrix = np.diag(np.where(active, 1.0, 0.0) / np.where(active, crossing, 1.0) ** 2 + np.where(active, 0.0, 1.0))
    for node, partner in enumerate(graph.partner.tolist()):
        a, b = int(graph.node_object[node]), int(graph.node_object[partner])
        if node < partner and active[a] and active[b]:
            contact = int(graph.contact[node])
            coupling = graph.share[contact] * graph.transmission[contact] ** 2
            matrix[[a, b], [a, b]] += coupling
            matrix[[a, b], [b, a]] -= coupling
    power = np.zeros((count, len(graph.sources)))
    for number, source in enumerate(graph.sources):
        for node in source.nodes:
            index = int(graph.node_object[node])
            power[index, number] += active[index] / len(source.nodes)
    energy = np.linalg.solve(matrix, power)
    return np.asarray(np.sqrt(np.maximum(0.0, energy[graph.node_object[graph.listener_nodes]].T)))


def _mean_gain(graph: HapticGraph, index: int) -> float:
    """Gain over the root mean square distance between the object's nodes."""
    positions = graph.node_position[graph.nodes_of(index)]
    if len(positions) < 2:
        distance = 0.0
    else:
        spread = ((positions - positions.mean(axis=0)) ** 2).sum(axis=1)
        distance = float(np.sqrt(2 * spread.sum() / (len(positions) - 1)))
    return float(graph.table.gain(index, np.array([distance]))[0])
