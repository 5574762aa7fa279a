"""What a listener feels of its ball: what reaches the nearest point of it."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from random import Random

import numpy as np
import pytest
from explicit_graph import explicit_graph
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.functions import Exponential
from haptic_tracing.core.scene.functions.physical import Physical, Wave
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Mode,
    Settings,
    Source,
    Strategy,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from level_properties import check_bounded, check_shown, check_steady, pile_scene
from path_reference import METRIC, OTHER, connected_scene, recursive_paths

SEEDS = st.integers(0, 10**6)
EVERYTHING = Settings(max_connections=None, threshold=0.0)
PAPER = replace(EVERYTHING, strategy=Strategy.AS_IN_THE_PAPER)


def extended(scene, radius):
    """The scene with volumes about its listeners; ``radius``: of each, or of all."""
    radii = radius if isinstance(radius, list) else [radius] * len(scene.listeners)
    heard = [replace(item, radius=r) for item, r in zip(scene.listeners, radii, strict=True)]
    return replace(scene, listeners=tuple(heard))


def products(scene, radii, column):
    """Gains of all paths to a listener, by recursion; the last connection is as long as the way to
    the nearest point of the volume."""
    graph = graph_of_scene(scene)
    explicit = explicit_graph(graph)
    for node, radius in zip(graph.listener_nodes.tolist(), radii, strict=True):
        item = graph.table.objects[graph.node_object[node]]
        for other, edge in explicit.pred[node].items():
            away = max(
                0.0, math.dist(graph.node_position[node], graph.node_position[other]) - radius
            )
            edge["gain"] = float(
                item.propagation.gain(np.array([away]), item.kappa, item.rho, graph.table.epsilon)[
                    0
                ]
            )
    return [math.prod(gains) for _, gains in recursive_paths(graph, 0, column, explicit)]


@pytest.mark.slow
@settings(max_examples=60, deadline=None, derandomize=True)
@given(SEEDS)
def test_the_largest_and_the_sum_over_all_paths_to_the_nearest_points(seed):
    plain = [
        function for function in (*METRIC, *OTHER) if function.name != "physical"
    ]  # whose bands decide which path is the best
    scene = connected_scene(seed, tuple(plain), listeners=3)
    radii = [Random(seed + k).choice([0.0, 0.1, 0.4, 2.0]) for k in range(len(scene.listeners))]
    graph = graph_of_scene(extended(scene, radii))
    best, total = propagate(graph, EVERYTHING), propagate(graph, PAPER)
    for column in range(len(radii)):
        gains = products(scene, radii, column)
        largest = max(gains, default=0.0)
        expected = largest if largest >= 1e-6 else 0.0
        assert best.gain[0, column] == pytest.approx(expected, rel=1e-9)
        assert total.gain[0, column] == pytest.approx(math.fsum(gains), rel=1e-9)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(SEEDS)
def test_the_best_path_is_that_to_the_best_point(seed):
    """No point listener in the volume feels more, and the nearest point on the way shown feels as
    much."""
    scene, random = connected_scene(seed, listeners=1), np.random.default_rng(seed)
    graph = graph_of_scene(extended(scene, 0.3))
    result = propagate(graph, EVERYTHING)
    centre = np.array(scene.listeners[0].position)

    def at(place):
        moved = replace(scene, listeners=(scene.listeners[0].moved(place),))
        return propagate(graph_of_scene(moved), EVERYTHING).gain[0, 0]

    for direction in random.normal(size=(12, 3)):
        step = direction / np.linalg.norm(direction) * 0.3 * random.uniform() ** (1 / 3)
        assert at(centre + step) <= result.gain[0, 0] * (1 + 1e-12)
    if (0, 0) in result.best_path:
        way = graph.node_position[result.best_path[0, 0][-2]] - centre
        nearest = centre + way * min(1.0, 0.3 / max(np.linalg.norm(way), 1e-9))
        assert at(nearest) == pytest.approx(result.gain[0, 0], rel=1e-9)


@pytest.mark.parametrize("strategy", list(Strategy))
@settings(max_examples=15, deadline=None, derandomize=True)
@given(SEEDS)
def test_monotone_in_the_radius_and_a_point_at_0(strategy, seed):
    scene = connected_scene(seed, extra=2, listeners=3, size=3.0)
    chosen = replace(EVERYTHING, strategy=strategy)
    point = propagate(graph_of_scene(extended(scene, 0.0)), chosen).gain
    gains = [
        point,
        *(
            propagate(graph_of_scene(extended(scene, radius)), chosen).gain
            for radius in (0.01, 0.1, 1.0, 50.0)
        ),
    ]
    for smaller, larger in itertools.pairwise(gains):
        assert (smaller <= larger * (1 + 1e-9)).all()


@pytest.mark.parametrize("strategy", list(Strategy))
def test_radii_of_1_cm_1_m_and_50_m_in_one_object(strategy):
    """exp(-0.2 (d - r)), and 1 inside the volume."""
    scene = HapticScene(
        (HapticObject("plate", 0, 1, Exponential(alpha=0.2)),),
        (),
        (Source("s", "plate"),),
        (Listener("palm", "plate", (9, 0, 12), radius=0.0),),
    )
    for radius, away in ((0.01, 14.99), (1.0, 14.0), (50.0, 0.0)):
        result = propagate(
            graph_of_scene(extended(scene, radius)), replace(EVERYTHING, strategy=strategy)
        )
        assert result.gain[0, 0] == pytest.approx(math.exp(-0.2 * away), rel=1e-12)
        direct = propagate(graph_of_scene(extended(scene, radius)), Settings(mode=Mode.MD)).gain[
            0, 0
        ]
        assert direct == pytest.approx(math.exp(-0.2 * away), rel=1e-12)


@settings(max_examples=12, deadline=None, derandomize=True)
@given(SEEDS)
def test_levels_stay_bounded_and_steady(seed):
    scene = extended(pile_scene(seed), 0.4)
    check_bounded(scene)
    check_steady(scene, seed)


@pytest.mark.slow
@settings(max_examples=2, deadline=None, derandomize=True)
@given(SEEDS)
def test_the_way_shown_makes_the_number_also_in_large_scenes(seed):
    scene = extended(pile_scene(seed, 60), 0.4)
    for listener in scene.listeners:  # NetworkX would go on through the volumes of others
        graph = graph_of_scene(replace(scene, listeners=(listener,)))
        check_shown(graph, propagate(graph, Settings()), 1e-6)
    together = propagate(graph_of_scene(scene), Settings()).gain
    alone = [
        propagate(graph_of_scene(replace(scene, listeners=(item,))), Settings()).gain[:, 0]
        for item in scene.listeners
    ]
    assert together == pytest.approx(np.transpose(alone), rel=1e-12)


def test_a_contact_that_enters_the_volume_changes_nothing_by_a_jump():
    """A finger that slides from 8 to 0 cm from a palm of 5 cm, by half millimetres."""
    objects = HapticObject("palm", 0.5, 0.8), HapticObject("finger", 0.1, 0.9)
    levels = []
    for place in np.arange(0.08, -0.0001, -0.0005).tolist():
        contact = Contact(("palm", "finger"), ((place, 0, 0), (place, 0, 0)))
        scene = HapticScene(
            objects,
            (contact,),
            (Source("s", "finger", (place, 0, 0.1)),),
            (Listener("l", "palm", radius=0.0),),
        )
        levels.append(
            20 * math.log10(propagate(graph_of_scene(extended(scene, 0.05)), Settings()).gain[0, 0])
        )
    assert max(abs(np.diff(levels))) < 0.0005 * 0.4 * 8.69 * 1.01, (
        "no more than the function of the palm over half a millimetre"
    )
    assert np.ptp(levels[-100:]) < 1e-9


def test_bands_and_delays_end_at_the_nearest_point():
    """Physical functions over 2 m, then 0.7 m less the radius of 0.2 m."""
    function = Physical(
        wave=Wave.SURFACE, loss_factor=0.3, phase_speed=150.0, reference_distance=0.3, extent=1.0
    )
    objects = HapticObject("floor", 0.2, 0.8, function), HapticObject("hand", 0.2, 0.8, function)
    contact = Contact(("floor", "hand"), ((2, 0, 0), (2, 0, 0)))
    scene = HapticScene(
        objects,
        (contact,),
        (Source("s", "floor"),),
        (Listener("l", "hand", (2, 0, 0.7), radius=0.0),),
    )
    shorter = replace(scene, listeners=(Listener("l", "hand", (2, 0, 0.5), radius=0.0),))
    found, expected = (
        propagate(graph_of_scene(item), Settings()) for item in (extended(scene, 0.2), shorter)
    )
    assert found.gain == pytest.approx(expected.gain, rel=1e-12)
    assert found.band_gain == pytest.approx(expected.band_gain, rel=1e-12)
    assert (
        found.delay == expected.delay
        if found.delay is None
        else found.delay == pytest.approx(expected.delay, rel=1e-12)
    )


def test_modes_choose_listeners_by_their_middles():
    objects = (HapticObject("o", 0, 1, Exponential(alpha=0.2)),)
    heard = (
        Listener("wide", "o", (3, 0, 0), radius=2.5),
        Listener("near", "o", (1, 0, 0), radius=0.0),
    )
    scene = HapticScene(objects, (), (Source("s", "o"),), heard)
    assert propagate(graph_of_scene(scene), Settings(mode=Mode.SD)).gain[0].tolist() == [
        0,
        pytest.approx(math.exp(-0.2)),
    ]
