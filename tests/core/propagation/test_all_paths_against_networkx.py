"""The sum over all paths against NetworkX's simple paths filtered by the path rules, and against
plain recursion."""

from __future__ import annotations

import math

import pytest
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.message import Cause
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.functions import Constant, Exponential, Identity
from haptic_tracing.core.scene.values import HapticScene, Settings, Strategy
from hypothesis import given, settings
from hypothesis import strategies as st
from path_reference import AMPLIFYING, METRIC, OTHER, REFERENCES, connected_scene, meets, scenes

LIMITS = st.tuples(
    st.sampled_from([None, 0, 1, 2, 3, 5, 7, 9]), st.sampled_from([0.0, 0.0, 1e-3, 0.1, 0.6, 1.0])
)
SEEDS = st.integers(0, 10**6)


def check(
    scene: HapticScene,
    max_connections: int | None,
    threshold: float,
    reference: str = "networkx",
    tolerance: float = 0.0,
) -> None:
    graph = graph_of_scene(scene)
    chosen = Settings(
        strategy=Strategy.ALL_PATHS,
        max_connections=max_connections,
        threshold=threshold,
        tolerance=tolerance,
    )
    result = propagate(graph, chosen)
    within = max_connections is None or (max_connections - 1) // 2 >= graph.contact_count
    for column in range(len(graph.listeners)):
        paths = [
            (gains, math.prod(gains))
            for _, gains in REFERENCES[reference](graph, 0, column)
            if math.prod(gains) > 0
        ]
        kept = [gain for gains, gain in paths if meets(gains, max_connections, threshold)]
        total, unlimited = math.fsum(kept), math.fsum(gain for _, gain in paths)
        gain, error = result.gain[0, column], result.error_bound[0, column]
        if tolerance == 0:
            assert gain == pytest.approx(total, rel=1e-9, abs=0)
        assert gain * (1 - 1e-9) <= total <= gain * (1 + tolerance) * (1 + 1e-9)
        assert unlimited <= (gain + error) * (1 + 1e-9)
        assert result.limited[0, column] == (
            error > tolerance * gain * (1 + 1e-12) and not (within and threshold == 0)
        )
        if within and threshold == 0:
            assert error <= tolerance * gain * (1 + 1e-9)
        if threshold > 0:
            assert result.paths[0, column] == len(kept)
    assert Cause.SUM_BUDGET not in {warning.cause for warning in result.warnings}


@pytest.mark.slow
@settings(max_examples=150, deadline=None, derandomize=True)
@given(scenes(METRIC, most_contacts=4, refined=True), LIMITS)
def test_sum_over_all_simple_paths(scene, limits):
    check(scene, *limits)


@pytest.mark.slow
@settings(max_examples=250, deadline=None, derandomize=True)
@given(SEEDS, LIMITS)
def test_longer_paths(seed, limits):
    check(connected_scene(seed, (*METRIC[:4], *OTHER), extra=4, listeners=4), *limits, "recursion")


@pytest.mark.slow
@settings(max_examples=100, deadline=None, derandomize=True)
@given(SEEDS, LIMITS)
def test_refined_patches(seed, limits):
    check(connected_scene(seed, METRIC[:2], extra=2, refined=True), *limits, "recursion")


@pytest.mark.slow
@settings(max_examples=100, deadline=None, derandomize=True)
@given(SEEDS, LIMITS)
def test_gains_above_1(seed, limits):
    check(
        connected_scene(
            seed,
            (*METRIC[:3], *AMPLIFYING, *OTHER),
            (Identity(), Constant(gain_value=1.3), Exponential()),
        ),
        *limits,
        "recursion",
    )


@pytest.mark.slow
@settings(max_examples=100, deadline=None, derandomize=True)
@given(SEEDS, st.sampled_from([None, 7]), st.sampled_from([0.5, 0.1, 1e-3]))
def test_tolerance_is_kept(seed, max_connections, tolerance):
    check(connected_scene(seed, METRIC[:3], extra=5), max_connections, 0.0, "recursion", tolerance)
