"""Small graphs are searched one entry at a time, larger ones in arrays, still larger ones in parts,
which leave out entries whose detour is too long: each of these on graphs that are small enough for
recursion over all paths."""

from __future__ import annotations

import math
from functools import cache

import pytest
from haptic_tracing.core.graph.haptic_graph import HapticGraph, graph_of_scene
from haptic_tracing.core.propagation import propagate, shortest_paths, spacing
from haptic_tracing.core.scene.values import Settings
from hypothesis import given, settings
from hypothesis import strategies as st
from path_reference import METRIC, OTHER, connected_scene, recursive_paths

SEEDS = st.integers(0, 10**6)
WAYS = {
    "heap": {"TINY": 10**9},
    "arrays": {"TINY": 0, "SPARSE": 0},
    "parts of arrays": {"TINY": 0, "SPARSE": 0, "BATCH": 3},
    "arrays, then the heap": {"TINY": 0, "SPARSE": 10**9},
}
LEAST = 1e-6


@cache
def expected(seed: int, functions: tuple[type, ...]) -> tuple[HapticGraph, list[float]]:
    """A graph, and by recursion the largest of the products of all paths to each listener."""
    graph = graph_of_scene(connected_scene(seed, functions, listeners=3))
    paths = (recursive_paths(graph, 0, column) for column in range(len(graph.listeners)))
    best = [max((math.prod(gains) for _, gains in found), default=0.0) for found in paths]
    return graph, [gain if gain >= LEAST else 0.0 for gain in best]


@pytest.mark.slow
@pytest.mark.parametrize("functions", [METRIC, (*METRIC, *OTHER)], ids=["metric", "any"])
@pytest.mark.parametrize("way", WAYS)
def test_shortest_paths(way, functions):
    @settings(max_examples=150, deadline=None, derandomize=True)
    @given(SEEDS)
    def check(seed):
        graph, best = expected(seed, functions)
        assert propagate(graph, Settings()).gain[0] == pytest.approx(best, rel=1e-9, abs=0)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(spacing, "MANY", 2)
        for name, value in WAYS[way].items():
            patch.setattr(shortest_paths, name, value)
        check()
