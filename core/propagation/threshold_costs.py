"""Least costs from the sources and to the listeners up to a threshold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from ..graph.haptic_graph import HapticGraph
from .connections import SLACK, cost_limit
from .shortest_paths import ShortestPaths, shortest_paths


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
