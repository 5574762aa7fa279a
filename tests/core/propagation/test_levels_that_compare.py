"""Levels of the default strategy: bounded, independent of cut-offs,
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
    check_bounded,
    check_local,
    check_shown,
    check_steady,
    pile_scene,
    traced,
)
from path_reference import METRIC, OTHER, connected_scene, recursive_paths

SEEDS = st.integers(0, 10**6)
PLACE = (0.0, 0.0, 0.0)


@pytest.mark.slow
@settings(max_examples=60, deadline=None, derandomize=True)
@given(SEEDS)
def test_scenes_of_any_functions_are_bounded(seed):
    scene = connected_scene(seed, (*METRIC, *OTHER), extra=4, listeners=4)
    check_bounded(scene)


@pytest.mark.slow
@settings(max_examples=20, deadline=None, derandomize=True)
@given(SEEDS)
def test_piles(seed):
    scene = pile_scene(seed)
    check_bounded(scene)
    check_steady(scene, seed)
    check_local(scene, "ground", (-14.0, 12.0, 0.0))


@pytest.mark.slow
@pytest.mark.parametrize("has_shape", [True, False])
@pytest.mark.parametrize("count", [100, 1000])
def test_a_body_far_away_on_the_same_ground_changes_no_level(has_shape, count):
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
        return propagate(graph, Settings()).gain

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
        check_shown(graph, propagate(graph, Settings()), 1e-6)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(SEEDS)
def test_between_the_best_way_and_the_power_sum_of_all(seed):
    scene = connected_scene(seed, METRIC, extra=3, listeners=3)
    graph = graph_of_scene(scene)
    found = traced(scene).gain
    for column in range(len(graph.listeners)):
        products = [math.prod(gains) for _, gains in recursive_paths(graph, 0, column)]
        assert (
            max(products, default=0.0) * (1 - 1e-9)
            <= found[0, column]
            <= math.hypot(*products) * (1 + 1e-9)
        )


def test_sums_in_the_same_piles_have_none_of_this():
    """What the default is not: in a dense pile a sum over paths is set by its threshold, and says
    so."""
    graph = graph_of_scene(pile_scene(1, 60))
    coarse, fine = (
        propagate(graph, Settings(strategy=Strategy.AS_IN_THE_PAPER, threshold=threshold))
        for threshold in (1e-2, 3e-3)
    )
    heard = coarse.gain > 0
    assert coarse.limited[heard].all() and fine.limited[heard].all()
    assert np.median(fine.gain[heard] / coarse.gain[heard]) > 1.5


@pytest.mark.parametrize("count", [1, 2, 5])
def test_two_objects_with_several_ways_between_them(count):
    """Ways without loss, side by side: the default is one of them."""
    objects = HapticObject("a", 0, 1, Identity()), HapticObject("b", 0, 1, Identity())
    scene = HapticScene(
        objects,
        (Contact(("a", "b"), (PLACE, PLACE)),) * count,
        (Source("s", "a"),),
        (Listener("l", "b", radius=0.0),),
    )
    assert traced(scene).gain[0, 0] == 1.0
