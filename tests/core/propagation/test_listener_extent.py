"""What a listener feels of its bounding volume: the largest gain over it, or the mean of the
powers, by every strategy."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from random import Random
from types import SimpleNamespace

import numpy as np
import pytest
from energy_reference import energy_gain
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.functions import Exponential, Linear
from haptic_tracing.core.scene.functions.physical import Physical, Wave
from haptic_tracing.core.scene.values import (
    Contact,
    Extent,
    HapticObject,
    HapticScene,
    Listener,
    Mode,
    Settings,
    Source,
    Strategy,
)
from hypothesis import example, given, settings
from hypothesis import strategies as st
from level_properties import WELL_POSED, check_bounded, check_shown, check_steady, pile_scene
from path_reference import METRIC, OTHER, connected_scene, recursive_paths
from scipy.integrate import quad

SEEDS = st.integers(0, 10**6)
EVERYTHING = Settings(max_connections=None, threshold=0.0)


def extended(scene, radius, extent=Extent.STRONGEST):
    """The scene with volumes about its listeners; ``radius``: of each, or of all."""
    radii = radius if isinstance(radius, list) else [radius] * len(scene.listeners)
    heard = [
        replace(item, radius=r, extent=extent)
        for item, r in zip(scene.listeners, radii, strict=True)
    ]
    return replace(scene, listeners=tuple(heard))


def products(scene, radii, column):
    """Gains of all paths to a listener, by recursion; the last connection is as long as the way to
    the nearest point of the volume."""
    graph = graph_of_scene(scene)
    explicit = graph.to_networkx()
    for node, radius in zip(graph.listener_nodes.tolist(), radii, strict=True):
        item = graph.table.objects[graph.node_object[node]]
        for other, edge in explicit[node].items():
            away = max(
                0.0, math.dist(graph.node_position[node], graph.node_position[other]) - radius
            )
            edge["gain"] = float(
                item.propagation.gain(np.array([away]), item.kappa, item.rho, graph.table.epsilon)[
                    0
                ]
            )
    form = SimpleNamespace(
        to_networkx=lambda: explicit,
        partner=graph.partner,
        sources=graph.sources,
        listener_nodes=graph.listener_nodes,
    )
    return [math.prod(gains) for _, gains in recursive_paths(form, 0, column)]


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
    best, total = (
        propagate(graph, replace(EVERYTHING, strategy=way))
        for way in (Strategy.BEST_PATH, Strategy.ALL_PATHS)
    )
    for column in range(len(radii)):
        gains = products(scene, radii, column)
        assert best.gain[0, column] == pytest.approx(max(gains, default=0.0), rel=1e-9, abs=1e-300)
        assert abs(total.gain[0, column] - sum(gains)) <= total.error_bound[0, column] + 1e-9 * sum(
            gains
        )


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
@example(460)  # a listener of 1 m on an object of 3 m in regions
def test_monotone_in_the_radius_and_a_point_at_0(strategy, seed):
    scene = connected_scene(seed, extra=2, listeners=3, size=3.0)
    chosen = replace(EVERYTHING, strategy=strategy)
    point = propagate(graph_of_scene(scene), chosen).gain
    for extent in Extent:
        assert (
            propagate(graph_of_scene(extended(scene, 0.0, extent)), chosen).gain.tobytes()
            == point.tobytes()
        )
    assert (
        propagate(graph_of_scene(extended(scene, 9.0, Extent.NONE)), chosen).gain.tobytes()
        == point.tobytes()
    )
    gains = [
        point,
        *(
            propagate(graph_of_scene(extended(scene, radius)), chosen).gain
            for radius in (0.01, 0.1, 1.0, 50.0)
        ),
    ]
    for smaller, larger in itertools.pairwise(gains):
        assert (
            smaller <= larger * (1 + 1e-9) + (1e-6 if strategy is Strategy.ENERGY_BALANCE else 0.0)
        ).all()


@pytest.mark.slow
@settings(max_examples=40, deadline=None, derandomize=True)
@given(SEEDS, st.sampled_from([0.1, 1.0, 50.0]))
# Three regions around one contact are the nearest ones, where rounding must not choose.
@example(4905, 1.0)
def test_energy_balance_by_its_definition(seed, radius):
    """Also by functions that let nothing through beyond a distance."""
    graph = graph_of_scene(
        extended(connected_scene(seed, (*METRIC, *OTHER, *OTHER), extra=3, size=6.0), radius)
    )
    result = propagate(graph, replace(EVERYTHING, strategy=Strategy.ENERGY_BALANCE))
    for column in range(len(graph.listeners)):
        exact = energy_gain(graph, 0, column)
        assert abs(result.gain[0, column] - exact) <= result.error_bound[0, column] + 1e-9 * exact


def test_energy_balance_on_a_plate_never_falls_with_the_radius():
    """The listener is near a source, and stays there: neither spread over a plate that is silent
    elsewhere, nor lost by a function of finite range that has no gain at its centre."""
    places = {f"p{k}": (2.0 * k, 0.0, 0.0) for k in range(8)}
    contacts = tuple(Contact(("plate", name), (place, place)) for name, place in places.items())
    pillars = tuple(HapticObject(name, 0.0, 1.0, Exponential(alpha=0.1)) for name in places)
    for function, away in ((Exponential(alpha=1.0), 0.5), (Linear(range=3.0), 5.0)):
        plate = HapticObject("plate", 0, 1, function)
        scene = HapticScene(
            (plate, *pillars),
            contacts,
            (Source("s", "p0"),),
            (Listener("l", "plate", (0.0, away, 0.0)),),
        )
        chosen = replace(EVERYTHING, strategy=Strategy.ENERGY_BALANCE)
        results = [
            propagate(graph_of_scene(extended(scene, radius)), chosen)
            for radius in (0.0, 0.5, 2.0, 4.0, 8.0, 20.0)
        ]
        for smaller, larger in itertools.pairwise(results):
            assert (smaller.gain - smaller.error_bound <= larger.gain + larger.error_bound).all()
        at_contact = replace(scene, listeners=(scene.listeners[0].moved((0.0, 0.0, 0.0)),))
        assert (
            results[-1].gain[0, 0] > 0.9 * propagate(graph_of_scene(at_contact), chosen).gain[0, 0]
        )


@pytest.mark.parametrize("strategy", list(Strategy))
def test_radii_of_1_cm_1_m_and_50_m_in_one_object(strategy):
    """exp(-0.2 (d - r)), and 1 inside the volume."""
    scene = HapticScene(
        (HapticObject("plate", 0, 1, Exponential(alpha=0.2)),),
        (),
        (Source("s", "plate"),),
        (Listener("palm", "plate", (9, 0, 12)),),
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
@given(SEEDS, st.sampled_from(WELL_POSED), st.sampled_from([Extent.STRONGEST, Extent.MEAN_POWER]))
def test_levels_stay_bounded_and_steady(seed, strategy, extent):
    scene = extended(pile_scene(seed), 0.4, extent)
    check_bounded(scene, strategy)
    check_steady(scene, strategy, seed)


@pytest.mark.slow
@settings(max_examples=2, deadline=None, derandomize=True)
@given(SEEDS)
def test_the_way_shown_makes_the_number_also_in_large_scenes(seed):
    scene = extended(pile_scene(seed, 60), 0.4)
    for listener in scene.listeners:  # NetworkX would go on through the volumes of others
        graph = graph_of_scene(replace(scene, listeners=(listener,)))
        check_shown(graph, propagate(graph, Settings()), Settings().threshold)
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
            objects, (contact,), (Source("s", "finger", (place, 0, 0.1)),), (Listener("l", "palm"),)
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
        objects, (contact,), (Source("s", "floor"),), (Listener("l", "hand", (2, 0, 0.7)),)
    )
    shorter = replace(scene, listeners=(Listener("l", "hand", (2, 0, 0.5)),))
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


@pytest.mark.parametrize("strategy", [Strategy.AUTO, Strategy.ALL_PATHS, Strategy.ENERGY_BALANCE])
def test_mean_power_is_that_of_the_points_of_the_volume(strategy):
    scene = extended(connected_scene(7, listeners=2), 0.25, Extent.MEAN_POWER)
    chosen = replace(EVERYTHING, strategy=strategy)
    graph = graph_of_scene(scene)
    found = propagate(graph, chosen)
    golden = (1 + math.sqrt(5)) / 2
    corners = [
        p for a in (-1, 1) for b in (-golden, golden) for p in ((0, a, b), (a, b, 0), (b, 0, a))
    ]
    for column, listener in enumerate(scene.listeners):
        power = 0.0
        for weight, corner in [(4 / 25, (0, 0, 0)), *((7 / 100, corner) for corner in corners)]:
            step = np.array(corner) / math.hypot(1, golden) * 0.25 * math.sqrt(5 / 7)
            point = replace(listener.moved(np.array(listener.position) + step), extent=Extent.NONE)
            power += (
                weight
                * propagate(graph_of_scene(replace(scene, listeners=(point,))), chosen).gain[0, 0]
                ** 2
            )
        assert found.gain[0, column] == pytest.approx(
            math.sqrt(power), rel=1e-6 if strategy is Strategy.ENERGY_BALANCE else 1e-9
        )
        assert found.best_path[0, column][-1] == graph.listener_nodes[column]


@pytest.mark.parametrize("away", [0.0, 0.05, 0.1, 0.3, 2.0])
def test_mean_power_is_the_integral_over_the_ball(away):
    """Of exp(-2 alpha rho): the share of a ball of radius r at the distance rho from a point is
    known (a cap of a sphere)."""
    alpha, radius = 0.9, 0.1

    def share(rho):
        if rho <= radius - away:
            return 4 * math.pi * rho**2
        return math.pi * rho / away * (radius**2 - (away - rho) ** 2)

    low, high = max(0.0, away - radius), away + radius
    bends = [abs(radius - away)] if low < abs(radius - away) < high else None
    integral = quad(lambda rho: share(rho) * math.exp(-2 * alpha * rho), low, high, points=bends)[0]
    scene = HapticScene(
        (HapticObject("o", 0, 1, Exponential(alpha=alpha)),),
        (),
        (Source("s", "o"),),
        (Listener("l", "o", (away, 0, 0)),),
    )
    found = propagate(graph_of_scene(extended(scene, radius, Extent.MEAN_POWER)), EVERYTHING).gain[
        0, 0
    ]
    assert 20 * math.log10(found) == pytest.approx(
        10 * math.log10(integral / (4 / 3 * math.pi * radius**3)), abs=0.05
    )


def test_modes_choose_listeners_by_their_middles():
    objects = (HapticObject("o", 0, 1, Exponential(alpha=0.2)),)
    heard = (
        Listener("wide", "o", (3, 0, 0), radius=2.5, extent="strongest"),
        Listener("near", "o", (1, 0, 0)),
    )
    scene = HapticScene(objects, (), (Source("s", "o"),), heard)
    assert propagate(graph_of_scene(scene), Settings(mode=Mode.SD)).gain[0].tolist() == [
        0,
        pytest.approx(math.exp(-0.2)),
    ]
    mean = replace(scene, listeners=(replace(heard[0], extent="mean_power"), heard[1]))
    assert propagate(graph_of_scene(mean), Settings(mode=Mode.MN)).gain[0] == pytest.approx(
        [1, 1], rel=1e-12
    )
    assert propagate(graph_of_scene(mean), Settings(mode=Mode.SD)).gain[0, 0] == 0


def test_an_extent_that_is_none_of_these_is_refused():
    with pytest.raises(ValueError, match="extent: must be one of none, strongest, mean_power"):
        Listener("l", "o", extent="wide")
