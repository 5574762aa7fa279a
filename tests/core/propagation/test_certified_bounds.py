"""Intervals: whatever the budget, the true sum lies between the gain and the gain plus its error
bound; and nothing runs away."""

from __future__ import annotations

import dataclasses
import math

import mpmath
import numpy as np
import pytest
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.message import Cause
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.propagation.best_path import crossings_of
from haptic_tracing.core.propagation.connections import LARGEST
from haptic_tracing.core.propagation.exact import PathLimits
from haptic_tracing.core.propagation.exact.contact_order import contacts_on_paths
from haptic_tracing.core.propagation.exact.frontier import Frontier
from haptic_tracing.core.propagation.exact.path_search import PathSearch
from haptic_tracing.core.propagation.exact.step_graph import build_step_graph
from haptic_tracing.core.propagation.exact.sums import sum_over_paths
from haptic_tracing.core.scene.functions import Constant, Expression, Identity
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Settings,
    Source,
    Strategy,
)
from hypothesis import example, given, settings
from hypothesis import strategies as st
from path_reference import AMPLIFYING, METRIC, OTHER, connected_scene, meets, recursive_paths

SEEDS = st.integers(0, 10**6)
ORIGIN = (0.0, 0.0, 0.0)


def true_sums(graph, max_connections=None, threshold=0.0) -> list[float]:
    return [
        math.fsum(
            math.prod(gains)
            for _, gains in recursive_paths(graph, 0, column)
            if meets(gains, max_connections, threshold)
        )
        for column in range(len(graph.listeners))
    ]


def assert_interval(graph, limits: PathLimits, true: list[float]) -> None:
    """The sum within the limits lies in the interval that is found for it."""
    found = sum_over_paths(graph, graph.sources[0].nodes, graph.listener_nodes.tolist(), limits)
    for gain, error, expected in zip(found.gain[:, 0], found.missing, true, strict=True):
        assert gain <= expected * (1 + 1e-12)
        assert expected <= (gain + error) * (1 + 1e-9)


@pytest.mark.slow
@settings(max_examples=150, deadline=None, derandomize=True)
@given(
    SEEDS,
    st.sampled_from([0, 10, 100, 1000, 10000]),
    st.sampled_from([None, 9]),
    st.sampled_from([0.0, 0.01, 0.3]),
)
def test_any_budget_and_tolerance(seed, budget, max_connections, tolerance):
    graph = graph_of_scene(connected_scene(seed, (*METRIC[:4], *OTHER), extra=4, listeners=3))
    chosen = Settings(
        strategy=Strategy.ALL_PATHS,
        max_connections=max_connections,
        threshold=0.0,
        tolerance=tolerance,
    )
    result = propagate(graph, chosen, budget)
    limited, unlimited = true_sums(graph, max_connections), true_sums(graph)
    for gain, error, true, most in zip(
        result.gain[0], result.error_bound[0], limited, unlimited, strict=True
    ):
        assert gain <= true * (1 + 1e-12)
        assert most <= (gain + error) * (1 + 1e-9)
    assert_interval(
        graph, PathLimits(crossings_of(max_connections), 0.0, tolerance, budget), limited
    )


@pytest.mark.slow
@settings(max_examples=100, deadline=None, derandomize=True)
@given(SEEDS, st.sampled_from([0, 4, 40, 400]), st.sampled_from([1e-3, 1e-2, 0.1]))
def test_any_budget_above_a_threshold(seed, budget, threshold):
    graph = graph_of_scene(connected_scene(seed, METRIC[:4], extra=4, listeners=3))
    result = propagate(
        graph,
        Settings(strategy=Strategy.ALL_PATHS, max_connections=None, threshold=threshold),
        budget,
    )
    limited = true_sums(graph, None, threshold)
    for gain, error, true, most in zip(
        result.gain[0], result.error_bound[0], limited, true_sums(graph), strict=True
    ):
        assert gain <= true * (1 + 1e-12)
        assert most <= (gain + error) * (1 + 1e-9)
    assert_interval(graph, PathLimits(math.inf, threshold, 0.0, budget), limited)


@pytest.mark.slow
@settings(max_examples=100, deadline=None, derandomize=True)
@given(SEEDS, st.sampled_from([0, 3, 30]))
def test_any_budget_for_best_paths_with_gains_above_1(seed, budget):
    graph = graph_of_scene(connected_scene(seed, (*METRIC[:2], *AMPLIFYING, *OTHER), extra=3))
    result = propagate(
        graph, Settings(strategy=Strategy.BEST_PATH, max_connections=None, threshold=0.0), budget
    )
    for column in range(len(graph.listeners)):
        true = max(
            (math.prod(gains) for _, gains in recursive_paths(graph, 0, column)), default=0.0
        )
        assert result.gain[0, column] <= true * (1 + 1e-12)
        assert true <= (result.gain[0, column] + result.error_bound[0, column]) * (1 + 1e-9)


@settings(max_examples=120, deadline=None, derandomize=True)
@given(SEEDS, st.sampled_from([0.0, 1e-300]), st.sampled_from([math.inf, 4.0]))
def test_search_with_and_without_merging(seed, threshold, crossings):
    """The search alone, without the frontier that usually is quicker in small scenes. A threshold
    keeps partial paths apart."""
    graph = graph_of_scene(connected_scene(seed, METRIC[:3], extra=4, listeners=3))
    entries = np.flatnonzero(graph.partner >= 0)
    roots, listeners = list(graph.sources[0].nodes), graph.listener_nodes.tolist()
    paths = build_step_graph(graph, entries, roots, listeners)
    found = PathSearch(paths, crossings, threshold).run(0.0, 10**7)
    true = true_sums(graph, None if crossings == math.inf else 9)
    assert found.gain[:, 0].tolist() == pytest.approx(true, rel=1e-12)
    assert found.missing.tolist() == [0.0] * len(listeners)


def dense(count: int, function) -> HapticScene:
    """Every two objects touch."""
    objects = tuple(HapticObject(f"o{i:02d}", 0.0, 1.0, function) for i in range(count))
    contacts = tuple(
        Contact((f"o{i:02d}", f"o{j:02d}"), (ORIGIN, ORIGIN))
        for i in range(count)
        for j in range(i)
    )
    return HapticScene(objects, contacts, (Source("s", "o00"),), (Listener("l", "o01"),))


def test_sum_that_grows_without_bound_is_reported():
    """Hundreds of lossless contacts: more paths than any number can count; a lower bound, a
    warning, and an end."""
    graph = graph_of_scene(dense(30, Identity()))
    result = propagate(
        graph, Settings(strategy=Strategy.ALL_PATHS, max_connections=None, threshold=0.0), 20_000
    )
    assert result.gain[0, 0] > 1
    assert result.error_bound[0, 0] == math.inf
    assert Cause.SUM_DIVERGES in {warning.cause for warning in result.warnings}
    limited = propagate(
        graph, Settings(strategy=Strategy.ALL_PATHS, max_connections=32, threshold=1e-3), 20_000
    )
    assert limited.gain[0, 0] > 1
    assert limited.error_bound[0, 0] == math.inf
    assert limited.limited[0, 0]
    assert {Cause.SUM_SET_BY_THRESHOLD, Cause.SUM_BUDGET} <= {
        warning.cause for warning in limited.warnings
    }
    found = sum_over_paths(
        graph,
        graph.sources[0].nodes,
        graph.listener_nodes.tolist(),
        PathLimits(15, 1e-3, 0.01, 20_000),
    )
    assert 0 < found.missing[0] < LARGEST


def test_amplifying_scene_ends():
    graph = graph_of_scene(dense(12, Expression(expression="x * (3 + d)")))
    for strategy in (Strategy.BEST_PATH, Strategy.ALL_PATHS, Strategy.ENERGY_BALANCE):
        for max_connections, threshold in ((32, 1e-3), (None, 0.0)):
            chosen = Settings(
                strategy=strategy, max_connections=max_connections, threshold=threshold
            )
            result = propagate(graph, chosen, 5_000)
            assert np.isfinite(result.gain).all()
            assert not np.isnan(result.error_bound).any()
            assert Cause.AMPLIFICATION in {warning.cause for warning in result.warnings}
    assert result.gain[0, 0] <= 1  # energy is not created


@pytest.mark.slow
@settings(max_examples=60, deadline=None, derandomize=True)
# The best path that was found is a number, the bound on others is none.
@example(230, 1e60, (None, 0.0), 100)
@given(
    SEEDS,
    st.sampled_from([1e60, 1e160, 1e308]),
    st.sampled_from([(None, 0.0), (32, 1e-3), (9, 0.0)]),
    st.sampled_from([100, 10000]),
)
def test_gains_too_large_for_a_number(seed, gain, limits, budget):
    """Products above 1e308 are no infinity but a lower bound, and nothing claims to be certain of
    them."""
    graph = graph_of_scene(
        connected_scene(
            seed, (Constant(gain_value=0.9), Expression(expression=f"{gain} / (1 + d)")), extra=3
        )
    )
    for strategy in (Strategy.BEST_PATH, Strategy.ALL_PATHS, Strategy.ENERGY_BALANCE):
        chosen = Settings(strategy=strategy, max_connections=limits[0], threshold=limits[1])
        result = propagate(graph, chosen, budget)
        for column in range(len(graph.listeners)):
            got, error = float(result.gain[0, column]), float(result.error_bound[0, column])
            assert 0 <= got <= LARGEST
            assert error >= 0
            if strategy is Strategy.ENERGY_BALANCE:
                assert got <= 1
                continue
            paths = [gains for _, gains in recursive_paths(graph, 0, column)]
            kept = [math.prod(map(mpmath.mpf, gains)) for gains in paths if meets(gains, *limits)]
            if strategy is Strategy.BEST_PATH:
                least = most = max(kept, default=mpmath.mpf(0))
            else:
                least, most = (
                    mpmath.fsum(kept),
                    mpmath.fsum(math.prod(map(mpmath.mpf, gains)) for gains in paths),
                )
            assert got <= least * (1 + 1e-12)
            assert error == math.inf or most <= (mpmath.mpf(got) + error) * (1 + 1e-9)


def test_amplification_without_a_contact_on_the_way():
    """The only object amplifies, and no path crosses a contact: the sum is the gain of that object
    alone."""
    thing = HapticObject("thing", 0.1, 0.9, Constant(gain_value=1.5))
    scene = HapticScene(
        (thing,), (), (Source("s", "thing"),), (Listener("l", "thing", (1.0, 0.0, 0.0)),)
    )
    result = propagate(graph_of_scene(scene), Settings(strategy=Strategy.ALL_PATHS))
    assert result.gain.tolist() == [[1.5]]


@pytest.mark.slow
def test_long_amplifying_chain_ends():
    """More contacts than layers are looked at: a bound instead of a path, and no memory of all the
    ways so far."""
    count = 3000
    objects = tuple(
        HapticObject(f"o{i:04d}", 0.0, 1.0, Expression(expression="1.01 * x")) for i in range(count)
    )
    contacts = tuple(
        Contact((f"o{i:04d}", f"o{i + 1:04d}"), (ORIGIN, ORIGIN)) for i in range(count - 1)
    )
    graph = graph_of_scene(
        HapticScene(
            objects, contacts, (Source("s", "o0000"),), (Listener("l", f"o{count - 1:04d}"),)
        )
    )
    best = propagate(
        graph, Settings(strategy=Strategy.BEST_PATH, max_connections=None, threshold=0.0), 100_000
    )
    total = propagate(
        graph, Settings(strategy=Strategy.ALL_PATHS, max_connections=None, threshold=0.0), 100_000
    )
    assert total.gain[0, 0] == pytest.approx(1.01**count, rel=1e-9)
    assert best.gain[0, 0] <= 1.01**count * (1 + 1e-9) <= best.gain[0, 0] + best.error_bound[0, 0]
    assert Cause.PATH_BUDGET in {warning.cause for warning in best.warnings}


def test_limited_connections_stay_exact_where_paths_are_countless():
    """Up to three contacts from one object to another, of 40 that all touch each other."""
    graph = graph_of_scene(dense(40, Constant(gain_value=0.5)))
    result = propagate(
        graph,
        Settings(strategy=Strategy.ALL_PATHS, max_connections=7, threshold=0.0, tolerance=0.0),
    )
    # No, one or two of the other 38 objects on the way: going back to where one was takes a contact
    # twice.
    expected = 0.5**2 + 38 * 0.5**3 + 38 * 37 * 0.5**4
    assert result.gain[0, 0] == pytest.approx(expected, rel=1e-12)
    assert result.limited[0, 0]
    assert result.error_bound[0, 0] == math.inf
    assert {warning.cause for warning in result.warnings} == {Cause.SUM_SET_BY_CONNECTIONS}
    assert (
        sum_over_paths(
            graph,
            graph.sources[0].nodes,
            graph.listener_nodes.tolist(),
            PathLimits(3, 0.0, 0.0, 10**6),
        ).missing[0]
        == 0
    )


def frontier(graph) -> Frontier:
    roots, listeners = graph.sources[0].nodes, graph.listener_nodes.tolist()
    return Frontier(graph, contacts_on_paths(graph, roots, listeners), roots, listeners, math.inf)


def test_frontier_gives_up_at_once():
    running = frontier(graph_of_scene(dense(12, Constant(gain_value=0.1))))
    assert running.expected > 2000
    running.expected = 0.0  # had the order promised more than it keeps
    assert running.sum(1000) is None
    assert running.work < 1000


def test_same_result_every_time():
    graph = graph_of_scene(connected_scene(5, METRIC[:3], extra=6, most_objects=9, listeners=4))
    chosen = Settings(strategy=Strategy.ALL_PATHS, max_connections=None, threshold=0.0)
    first, second = (propagate(graph, chosen, 500) for _ in range(2))
    assert dataclasses.asdict(first)["gain"].tolist() == dataclasses.asdict(second)["gain"].tolist()
    assert first.error_bound.tolist() == second.error_bound.tolist()


def test_frontier_given_up_again_and_again():
    """Whatever work it was given before, the sum is the same to the last bit."""
    graph = graph_of_scene(dense(6, Constant(gain_value=0.9)))
    whole, tried = frontier(graph).sum(1e9), frontier(graph)
    sums = [tried.sum(part) for part in np.geomspace(1, tried.expected + 10**6, 8)]
    assert sums[0] is None and sums[-1].tolist() == whole.tolist()
