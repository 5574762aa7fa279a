"""How far apart the nodes of objects with many of them lie."""

from __future__ import annotations

import math

import numpy as np

from ..arrays import FloatArray
from ..graph.haptic_graph import HapticGraph, lengths

MANY = 48
"""Objects of fewer nodes are not examined."""


def spacing(graph: HapticGraph) -> FloatArray:
    """Lower bounds (n,) on the distances [m] from each node to the others of its object, 0 in
    objects with few nodes."""
    result = np.zeros(graph.node_count)
    for index in ((graph.start[1:] - graph.start[:-1]) >= MANY).nonzero()[0].tolist():
        nodes = graph.nodes_of(index)
        result[nodes] = _nearest(graph.node_position[nodes])
    if graph.reach is not None:
        result = np.maximum(result - 2 * graph.reach.max(), 0.0)
    return result


def _nearest(places: FloatArray) -> FloatArray:
    """Lower bounds (n,) on the distances of ``places`` (n, 3) to the nearest other one: in order
    along their longest extent, of the next ones the distance, of all others the difference along
    it."""
    longest = (places.max(axis=0) - places.min(axis=0)).argmax()
    order = places[:, longest].argsort(kind="stable")
    ordered = places[order].T.copy()
    nearest = np.full(len(places), math.inf)
    beyond = math.isqrt(len(places)) + 1
    for step in range(1, beyond + 1):
        apart = ordered[:, step:] - ordered[:, :-step]
        distance = apart[longest] if step == beyond else lengths(*apart)
        for side in (nearest[step:], nearest[:-step]):
            np.minimum(side, distance, out=side)
    result = np.empty_like(nearest)
    result[order] = nearest
    return result
