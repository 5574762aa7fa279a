"""Levels of the default strategy and of the energy balance: bounded, independent of cut-offs,
steady, local, and made by the ways shown."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.benchmarks.families import pile
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.functions import Identity
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Settings,
    Source,
    Strategy,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from level_properties import (
    WELL_POSED,
    check_bounded,
    check_cut_offs,
    check_local,
    check_shown,
    check_steady,
    pile_scene,
    traced,
)
from path_reference import METRIC, OTHER, connected_scene, recursive_paths

SEEDS = st.integers(0, 10**6)
PLACE = (0.0, 0.0, 0.0)
both = pytest.mark.parametrize("strategy", WELL_POSED)


@pytest.mark.slow
@both
@settings(max_examples=60, deadline=None, derandomize=True)
@given(SEEDS)
def test_scenes_of_any_functions_are_bounded_and_independent_of_cut_offs(strategy, seed):
    scene = connected_scene(seed, (*METRIC, *OTHER), extra=4, listeners=4)
    check_bounded(scene, strategy)
    check_cut_offs(scene, strategy)


@pytest.mark.slow
@both
@settings(max_examples=20, deadline=None, derandomize=True)
@given(SEEDS)
def test_piles(strategy, seed):
    scene = pile_scene(seed)
    check_bounded(scene, strategy)
    check_cut_offs(scene, strategy)
    check_steady(scene, strategy, seed)
    check_local(scene, strategy, "ground", (-14.0, 12.0, 0.0))


@pytest.mark.slow
@both
@pytest.mark.parametrize("has_shape", [True, False])
@pytest.mark.parametrize("count", [100, 1000])
def test_a_body_far_away_on_the_same_ground_changes_no_level(strategy, has_shape, count):
    """One body more, 27 to 200 m from the middle of a pile, which is 6 to 19 m wide: under 0.5
    dB."""
    family = pile(count)
    objects, names = family.table.objects, family.table.names
    contacts = family.contacts.to_contacts(names)

    def gains(far: float | None) -> np.ndarray:
        place = (far or 0.0, 0.0, 0.0)
        more = (
            (replace(objects[-1], name="object far"),),
            (Contact((names[0], "object far"), (place, place)),),
        )
        added = more if far else ((), ())
        graph = graph_of_scene(
            HapticScene(
                (*objects, *added[0]), (*contacts, *added[1]), family.sources, family.listeners
            )
        )
        if has_shape:
            centre = graph.frames.centre.copy()
            centre[0] = 9.0, 9.0, -1.0
            size = graph.frames.size.copy()
            size[0] = 400.0, 400.0, 2.0
            graph = replace(graph, frames=replace(graph.frames, centre=centre, size=size))
        return propagate(graph, Settings(strategy=strategy)).gain

    alone = gains(None)
    for far in (27.0, 60.0, 200.0):
        with_it = gains(far)
        felt = (alone > 1e-3) | (with_it > 1e-3)
        assert felt.any()
        assert np.abs(20 * np.log10(alone[felt] / with_it[felt])).max() < 0.5


@settings(max_examples=20, deadline=None, derandomize=True)
@given(SEEDS)
def test_the_way_shown_makes_the_number(seed):
    for scene in (pile_scene(seed), connected_scene(seed, METRIC, extra=4, listeners=4)):
        graph = graph_of_scene(scene)
        check_shown(graph, propagate(graph, Settings()), Settings().threshold)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(SEEDS)
def test_between_the_best_way_and_the_power_sum_of_all(seed):
    scene = connected_scene(seed, METRIC, extra=3, listeners=3)
    graph = graph_of_scene(scene)
    found = traced(scene, Strategy.AUTO, threshold=0.0).gain
    for column in range(len(graph.listeners)):
        products = [math.prod(gains) for _, gains in recursive_paths(graph, 0, column)]
        assert (
            max(products, default=0.0) * (1 - 1e-9)
            <= found[0, column]
            <= math.hypot(*products) * (1 + 1e-9)
        )


def test_sums_in_the_same_piles_have_none_of_this():
    """What the default is not: in a dense pile a sum over paths is above its source, and set by its
    threshold, and says so."""
    scene = pile_scene(1, 60)
    coarse, fine = (
        traced(scene, Strategy.ALL_PATHS, threshold=threshold) for threshold in (1e-2, 3e-3)
    )
    assert coarse.limited.all() and fine.limited.all()
    heard = coarse.gain > 0
    assert np.median(fine.gain[heard] / coarse.gain[heard]) > 1.5
    assert coarse.statistics["walk_radius"] > 1


@pytest.mark.parametrize("count", [1, 2, 5])
def test_two_objects_with_several_ways_between_them(count):
    """Ways without loss, side by side: the default is one of them, the balance is not above it,
    and nearer to it the more there are."""
    objects = HapticObject("a", 0, 1, Identity()), HapticObject("b", 0, 1, Identity())
    scene = HapticScene(
        objects,
        (Contact(("a", "b"), (PLACE, PLACE)),) * count,
        (Source("s", "a"),),
        (Listener("l", "b"),),
    )
    assert traced(scene, Strategy.AUTO).gain[0, 0] == 1.0
    balance = traced(scene, Strategy.ENERGY_BALANCE)
    assert balance.gain[0, 0] == pytest.approx(
        # Two objects that each take up 1/200 and a third of the rest, with a coupling of ``count``.
        math.sqrt(1 / (1 + 0.995**2 / 9 / count + 0.005 * (0.005 + 2 * 0.995 / 3) / count + 0.005)),
        abs=balance.error_bound[0, 0] + 1e-12,
    )
