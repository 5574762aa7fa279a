"""Delays of a sum over paths: its strongest paths, each with its delay and its gain."""

from __future__ import annotations

import math

import numpy as np

from ..graph.haptic_graph import HapticGraph
from .connections import HOPS, bounded_exp, cost_limit, path_delay
from .hop_constrained import hop_constrained_paths
from .shortest_paths import shortest_paths
from .strongest_paths import StrongestPaths

TAPS = 8
"""Most paths whose delays are given."""

SEARCHED = 4096
"""Most partial paths examined for one pair."""


def delay_taps(
    graph: HapticGraph, row: int, column: int, crossings: float, threshold: float, amplified: bool
) -> tuple[tuple[float, float], ...]:
    """(delay [s], gain) of up to `TAPS` of the strongest paths of a pair within both limits, the strongest first.

    The gain of a path through points of patches includes their shares.
    """
    target = int(graph.listener_nodes[column])
    limit = cost_limit(threshold)
    if amplified:
        most = int(min(crossings, graph.contact_count, HOPS))
        ahead = hop_constrained_paths(graph, (target,), math.inf, most, complete=True).costs(graph.node_count)
        crossings = min(crossings, most)
    else:
        ahead = shortest_paths(graph, [(target,)], np.array([limit]), complete=True).cost
    taps: list[tuple[float, float]] = []
    for path in StrongestPaths(graph, graph.sources[row].nodes, target, ahead, crossings, limit, SEARCHED):
        taps.append((path_delay(graph, path.nodes), path.share * bounded_exp(-path.cost)))
        if len(taps) == TAPS:
            break
    return tuple(taps)
