"""Propagation: from the haptic graph to the gain of every source at every listener."""

from __future__ import annotations

from ..graph.haptic_graph import HapticGraph
from .result import Propagation
from .strategies import propagate

__all__ = ["Propagation", "objects_on", "propagate"]


def objects_on(graph: HapticGraph, nodes: tuple[int, ...]) -> tuple[str, ...]:
    """Names of the objects along a path of nodes, in order, without consecutive duplicates."""
    names: list[str] = []
    for node in nodes:
        name = graph.table.names[graph.node_object[node]]
        if not names or names[-1] != name:
            names.append(name)
    return tuple(names)
