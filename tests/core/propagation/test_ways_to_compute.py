"""Small graphs are computed one number at a time, larger ones in arrays, still larger ones in
parts: each of these on graphs that are small enough for recursion over all paths."""

from __future__ import annotations

import math
from functools import cache

import pytest
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.message import Cause
from haptic_tracing.core.propagation import propagate, shortest_paths
from haptic_tracing.core.scene.values import HapticScene, Settings, Strategy
from hypothesis import given, settings
from hypothesis import strategies as st
from path_reference import METRIC, OTHER, connected_scene, meets, recursive_paths

SEEDS = st.integers(0, 10**6)
LIMITS = st.tuples(st.sampled_from([None, 5, 7]), st.sampled_from([1e-3, 0.1]))
WAYS = {
    "scalars": {"FEW": 10**9},
    "large objects": {"FEW": 10**9, "LARGE": 2},
    "scalars in place": {"FEW": 10**9, "SMALL": 0},
    "arrays": {"FEW": 0},
    "parts of arrays": {"FEW": 0, "BATCH": 3},
    "arrays, then the heap": {"FEW": 0, "SPARSE_ROUNDS": 2, "SPARSE": 10**9},
}


@cache
def scene_of(seed: int) -> HapticScene:
    return connected_scene(seed, (*METRIC, *OTHER), listeners=3)


@cache
def sums_and_bests(
    seed: int, limits: tuple[int | None, float]
) -> tuple[list[float], list[float], list[float]]:
    """By recursion: the sum and the largest of the products of all paths within the limits, and the
    largest without limits, for each listener."""
    graph = graph_of_scene(scene_of(seed))
    sums, bests, free = [], [], []
    for column in range(len(graph.listeners)):
        paths = [gains for _, gains in recursive_paths(graph, 0, column)]
        kept = [math.prod(gains) for gains in paths if meets(gains, *limits)]
        sums.append(math.fsum(kept))
        bests.append(max(kept, default=0.0))
        free.append(max(map(math.prod, paths), default=0.0))
    return sums, bests, free


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_shortest_paths(way):
    @settings(max_examples=150, deadline=None, derandomize=True)
    @given(SEEDS, LIMITS)
    def check(seed, limits):
        sums, bests, free = sums_and_bests(seed, limits)
        chosen = {"max_connections": limits[0], "threshold": limits[1]}
        graph = graph_of_scene(scene_of(seed))
        for strategy, expected in ((Strategy.BEST_PATH, bests), (Strategy.ALL_PATHS, sums)):
            result = propagate(graph, Settings(strategy=strategy, **chosen))
            assert result.gain[0] == pytest.approx(expected, rel=1e-9, abs=0)
            assert Cause.SUM_BUDGET not in {warning.cause for warning in result.warnings}
            if strategy is Strategy.BEST_PATH:
                assert (abs(result.gain[0] - free) <= result.error_bound[0] + 1e-9).all()

    with pytest.MonkeyPatch.context() as patch:
        for name, value in WAYS[way].items():
            patch.setattr(shortest_paths, name, value)
        check()
