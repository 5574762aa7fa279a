"""The paper's sum over all paths against NetworkX's simple paths filtered by the path rules, and
against plain recursion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.message import Cause
from haptic_tracing.core.propagation import breadth_first, propagate
from haptic_tracing.core.scene.functions import Constant, Exponential, Identity
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Mode,
    Settings,
    Source,
    SourceKind,
    Strategy,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from path_reference import METRIC, OTHER, REFERENCES, connected_scene, meets, scenes

LIMITS = st.tuples(
    st.sampled_from([None, 0, 1, 2, 3, 5, 7, 9]), st.sampled_from([0.0, 0.0, 1e-3, 0.1, 0.6, 1.0])
)
SEEDS = st.integers(0, 10**6)


def check(
    scene: HapticScene, max_connections: int | None, threshold: float, reference: str = "networkx"
) -> None:
    graph = graph_of_scene(scene)
    result = propagate(
        graph, Settings(Mode.HT, Strategy.AS_IN_THE_PAPER, max_connections, threshold)
    )
    for column in range(len(graph.listeners)):
        paths = [
            (gains, math.prod(gains))
            for _, gains in REFERENCES[reference](graph, 0, column)
            if math.prod(gains) > 0
        ]
        kept = [gain for gains, gain in paths if meets(gains, max_connections, threshold)]
        assert result.gain[0, column] == pytest.approx(math.fsum(kept), rel=1e-9, abs=0)
        assert result.paths[0, column] == len(kept)
        if len(kept) < len(paths):
            assert result.limited[0, column]
        assert ((0, column) in result.best_path) == any(gain >= 1e-6 for gain in kept)
        if max_connections is None and threshold == 0:
            assert not result.limited[0, column]
    assert not result.warnings


@pytest.mark.slow
@settings(max_examples=150, deadline=None, derandomize=True)
@given(scenes(METRIC, most_contacts=4, refined=True), LIMITS)
def test_sum_over_all_simple_paths(scene, limits):
    check(scene, *limits)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(SEEDS, LIMITS)
def test_longer_paths(seed, limits):
    check(connected_scene(seed, (*METRIC[:4], *OTHER), extra=4, listeners=4), *limits, "recursion")


@pytest.mark.slow
@settings(max_examples=100, deadline=None, derandomize=True)
@given(SEEDS, LIMITS)
def test_refined_patches(seed, limits):
    check(connected_scene(seed, METRIC[:2], extra=2, refined=True), *limits, "recursion")


@pytest.mark.parametrize("threshold", [0.0, 1e-3])
def test_source_of_two_sides_in_separate_pieces_one_with_a_loop(threshold):
    """As an impact has when the two bodies part again: one falls back on three that stand in a
    ring, the other one flies."""
    at = (0.0, 0.0, 0.0)
    half = Constant(gain_value=0.5)
    ring = [("a", "b"), ("b", "c"), ("c", "a")]
    scene = HapticScene(
        tuple(HapticObject(name, 0.0, 1.0, half) for name in ("a", "b", "c", "flying")),
        tuple(Contact(pair, (at, at), Exponential()) for pair in ring),
        (Source("s", "a", at, second_object="flying", second_position=at),),
        (Listener("l", "c", at, radius=0.0), Listener("m", "flying", at, radius=0.0)),
    )
    check(scene, None, threshold)
    found = propagate(
        graph_of_scene(scene), Settings(Mode.HT, Strategy.AS_IN_THE_PAPER, threshold=threshold)
    )
    # One path over the contact of a and c, one by way of b; on the other side one connection.
    assert found.gain[0].tolist() == pytest.approx([0.25 + 0.125, 0.5])


def test_temporary_sources_take_the_best_path():
    scene = connected_scene(5, METRIC[:1], extra=4)
    ends = [Source("s", "o0"), Source("t", "o0", kind=SourceKind.TEMPORARY)]
    graph = graph_of_scene(HapticScene(scene.objects, scene.contacts, tuple(ends), scene.listeners))
    paper = propagate(graph, Settings(strategy=Strategy.AS_IN_THE_PAPER))
    best = propagate(graph, Settings())
    assert paper.strategy == ("as_in_the_paper", "best_path")
    assert paper.gain[1].tolist() == best.gain[1].tolist()
    assert (paper.gain[0] >= best.gain[0]).all()
    assert (paper.gain[0] > best.gain[0]).any()


@pytest.mark.parametrize("budget", [0, 10, 100, 1000])
def test_the_budget_ends_the_search_and_is_told(budget, monkeypatch):
    """A complete graph of six lossless objects, by recursion over all of its paths."""
    names = [f"o{k}" for k in range(6)]
    at = (0.0, 0.0, 0.0)
    scene = HapticScene(
        tuple(HapticObject(name, 0.0, 1.0, Identity()) for name in names),
        tuple(
            Contact((a, b), (at, at), Constant(gain_value=0.5))
            for k, a in enumerate(names)
            for b in names[:k]
        ),
        (Source("s", "o0"),),
        (Listener("l", "o1", radius=0.0),),
    )
    graph = graph_of_scene(scene)
    sums = breadth_first.sums_over_paths
    monkeypatch.setattr(
        "haptic_tracing.core.propagation.strategies.sums_over_paths",
        lambda *arguments: sums(*arguments, budget=budget),
    )
    found = propagate(graph, Settings(Mode.HT, Strategy.AS_IN_THE_PAPER, 9, 0.0))
    total = math.fsum(
        math.prod(gains)
        for _, gains in REFERENCES["recursion"](graph, 0, 0)
        if meets(gains, 9, 0.0)
    )
    assert 0 <= found.gain[0, 0] < total
    assert found.limited[0, 0]
    assert [warning.cause for warning in found.warnings] == [Cause.SUM_BUDGET]
    assert np.isfinite(found.gain).all()
