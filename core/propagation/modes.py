"""The four renderings of the paper's study: what each makes of the haptic graph."""

from __future__ import annotations

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..graph.distance_only import DISTANCE_ONLY
from ..graph.haptic_graph import HapticGraph, distances
from .shortest_paths import LIMIT


def straight_distances(graph: HapticGraph) -> FloatArray:
    """Straight-line distance (s, l) in metres between sources and the middles of listeners, from
    the nearer side of a source that feeds two objects."""
    listeners = graph.node_position[graph.listener_nodes]
    rows = [
        distances(graph.node_position[list(source.nodes)][:, None, :], listeners[None, :, :]).min(
            axis=0
        )
        for source in graph.sources
    ]
    return np.array(rows, dtype=np.float64).reshape(len(graph.sources), len(graph.listeners))


def nearest_listener(graph: HapticGraph) -> BoolArray:
    """(s, l) True for the listener nearest to each source; of several at the same distance, the
    first by name."""
    chosen = np.zeros((len(graph.sources), len(graph.listeners)), dtype=np.bool_)
    for row, line in enumerate(straight_distances(graph)):
        if len(line):
            best = min(range(len(line)), key=lambda k: (line[k], graph.listeners[k]))
            chosen[row, best] = True
    return chosen


def direct_gains(graph: HapticGraph, attenuated: bool) -> FloatArray:
    """Gains (s, l) of one straight connection from every source to every listener: over distance,
    0 below -120 dB, or 1."""
    line = straight_distances(graph)
    if graph.reach is not None:
        line = np.maximum(line - graph.reach[graph.listener_nodes], 0.0)
    cost = DISTANCE_ONLY.alpha * line if attenuated else np.zeros_like(line)
    return np.where(cost <= LIMIT, np.exp(-cost), 0.0)
