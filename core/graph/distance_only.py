"""The haptic graph of mode SD, whose gains depend on distance only."""

from __future__ import annotations

import dataclasses

import numpy as np

from ..scene.functions import Exponential
from .haptic_graph import HapticGraph

DISTANCE_ONLY = Exponential(alpha=0.2)
"""The paper's distance-only function (equation 4)."""


def distance_only(graph: HapticGraph) -> HapticGraph:
    """The graph with `DISTANCE_ONLY` as the propagation function of every object, without bands and
    delays; its objects are unchanged."""
    count = len(graph.table.names)
    table = dataclasses.replace(
        graph.table,
        factor=np.ones(count),
        decay=np.full(count, DISTANCE_ONLY.alpha),
        loss=np.zeros(count),
        spreading=None,
        special=frozenset(),
        band_gains=None,
        band_decays=None,
        slowness=None,
    )
    return dataclasses.replace(graph, table=table)
