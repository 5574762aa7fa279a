"""Delays of a sum over paths: its strongest paths, each with its delay and its gain."""

from __future__ import annotations

import itertools
import math

import numpy as np

from ..graph.contact_patches import contact_patches
from ..graph.haptic_graph import HapticGraph
from .best_path import bounded_exp
from .connections import cost_limit, path_delay
from .hop_constrained import hop_constrained_paths
from .shortest_paths import shortest_paths
from .strongest_paths import StrongestPaths

TAPS = 8
"""Paths whose delays are given."""

SEARCHED = 4096
"""Partial paths looked at for one pair."""

HOPS = 64


def delay_taps(
    graph: HapticGraph, row: int, column: int, crossings: float, threshold: float, amplified: bool
) -> tuple[tuple[float, float], ...]:
    """(delay [s], gain with shares) of up to `TAPS` of the strongest paths of a pair, the strongest first, within both limits."""
    target = int(graph.listener_nodes[column])
    limit = cost_limit(threshold)
    if amplified:
        most = int(min(crossings, graph.contact_count, HOPS))
        ahead = hop_constrained_paths(graph, (target,), math.inf, most, complete=True).costs(graph.node_count)
        crossings = min(crossings, most)
    else:
        ahead = shortest_paths(graph, [(target,)], np.array([limit]), complete=True).cost
    patch = contact_patches(graph)
    found: list[tuple[float, float]] = []
    for path in StrongestPaths(graph, graph.sources[row].nodes, target, ahead, crossings, limit, SEARCHED):
        contacts = [int(graph.contact[a]) for a, b in itertools.pairwise(path.nodes) if graph.partner[a] == b]
        if len({int(patch[contact]) for contact in contacts}) == len(contacts):
            share = math.prod(float(graph.share[contact]) for contact in contacts)
            found.append((path_delay(graph, path.nodes), share * bounded_exp(-path.cost)))
        if len(found) == TAPS:
            break
    return tuple(found)
