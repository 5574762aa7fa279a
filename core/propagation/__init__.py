"""Propagation: from the haptic graph to the gain of every source at every listener."""

from __future__ import annotations

import itertools

from ..graph.haptic_graph import HapticGraph
from .result import Propagation
from .strategies import propagate

__all__ = ["Propagation", "objects_on", "propagate"]


def objects_on(graph: HapticGraph, nodes: tuple[int, ...]) -> tuple[str, ...]:
    """Names of the objects along a path of nodes, in order, without consecutive duplicates."""
    return tuple(
        name
        for name, _ in itertools.groupby(
            graph.table.names[graph.node_object[node]] for node in nodes
        )
    )
