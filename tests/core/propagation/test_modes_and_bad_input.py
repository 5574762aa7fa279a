"""The four renderings by their formulas, and what propagation says to bad input."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.graph.haptic_graph import NoGain, ObjectTable, build_graph, graph_of_scene
from haptic_tracing.core.propagation import objects_on, propagate
from haptic_tracing.core.scene.functions import Constant, Exponential, Expression, Identity
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
from path_reference import connected_scene

SCENE = HapticScene(
    objects=(
        HapticObject("ground", 0.2, 0.9),
        HapticObject("bench", 0.1, 0.8),
        HapticObject("kite", 0.5, 0.5),
    ),
    contacts=(Contact(("ground", "bench"), ((1, 0, 0), (1, 0, 0))),),
    sources=(
        Source("drill", "ground"),
        Source("bump", "bench", (1, 0, 0), kind="temporary", second_object="ground"),
    ),
    listeners=(
        Listener("seat", "bench", (1.2, 0, 0.4), radius=0.0),
        Listener("hand", "kite", (0, 0, 3), radius=0.0),
        Listener("foot", "ground", (0, 1, 0), radius=0.0),
    ),
)
GRAPH = graph_of_scene(SCENE)
LINE = np.array(
    [[math.dist(s.position, k.position) for k in SCENE.listeners] for s in SCENE.sources]
)


@pytest.mark.parametrize("strategy", list(Strategy))
def test_direct_modes(strategy):
    """MD: exp(-0.2 d) straight to everybody, touching or not; MN: 1."""
    for mode, expected in ((Mode.MD, np.exp(-0.2 * LINE)), (Mode.MN, np.ones_like(LINE))):
        result = propagate(GRAPH, Settings(mode=mode, strategy=strategy))
        assert np.allclose(result.gain, expected, rtol=1e-14)
        assert result.paths.tolist() == np.ones((2, 3), dtype=int).tolist()
        assert objects_on(GRAPH, result.best_path[0, 1]) == ("ground", "kite")


def test_nearest_listener_on_the_graph():
    """SD: over the graph, by distance alone, and only the listener nearest to each source."""
    result = propagate(GRAPH, Settings(mode=Mode.SD))
    assert result.gain[0].tolist() == [0, 0, pytest.approx(math.exp(-0.2), rel=1e-14)]
    way = math.exp(-0.2 * math.dist((1, 0, 0), (1.2, 0, 0.4)))
    assert result.gain[1].tolist() == [pytest.approx(way, rel=1e-14), 0, 0]


def test_nearest_listener_ties_go_by_name():
    listeners = (
        Listener("right", "ground", (1, 0, 0), radius=0.0),
        Listener("left", "ground", (-1, 0, 0), radius=0.0),
    )
    scene = HapticScene(SCENE.objects, (), (Source("s", "ground"),), listeners)
    assert propagate(graph_of_scene(scene), Settings(mode=Mode.SD)).gain[0].tolist() == [
        0,
        pytest.approx(math.exp(-0.2)),
    ]


def test_strategies_of_sources():
    """The best path for every source, unless all is to be as in the paper."""
    assert propagate(GRAPH, Settings()).strategy == ("best_path", "best_path")
    assert propagate(GRAPH, Settings(strategy=Strategy.AS_IN_THE_PAPER)).strategy == (
        "as_in_the_paper",
        "best_path",
    )


@pytest.mark.parametrize("strategy", list(Strategy))
def test_nearest_listener_by_best_path_whatever_the_strategy(strategy):
    """Mode SD is the largest product of gains by distance alone, also between objects that touch
    each other all around."""
    names = ["a", "b", "c", "d"]
    objects = tuple(HapticObject(name, 0.0, 1.0) for name in names)
    contacts = tuple(
        Contact((one, other), ((0, 0, 0), (0, 0, 0)))
        for k, one in enumerate(names)
        for other in names[:k]
    )
    scene = HapticScene(
        objects, contacts, (Source("s", "a"),), (Listener("l", "b", (1, 0, 0), radius=0.0),)
    )
    result = propagate(graph_of_scene(scene), Settings(mode=Mode.SD, strategy=strategy))
    assert result.strategy == ("best_path",)
    assert result.gain[0, 0] == pytest.approx(math.exp(-0.2), rel=1e-14)


def test_the_best_path_has_no_limit_of_connections():
    """Through 40 objects in a row, which takes 79 connections."""
    objects = tuple(HapticObject(f"o{k:02d}", 0, 1, Identity()) for k in range(40))
    contacts = tuple(
        Contact((f"o{k:02d}", f"o{k + 1:02d}"), ((k, 0, 0), (k, 0, 0))) for k in range(39)
    )
    graph = graph_of_scene(
        HapticScene(objects, contacts, (Source("s", "o00"),), (Listener("l", "o39", radius=0.0),))
    )
    assert propagate(graph, Settings()).gain[0, 0] == 1
    for most, gain in ((32, 0), (78, 0), (79, 1), (None, 1)):
        chosen = Settings(strategy=Strategy.AS_IN_THE_PAPER, max_connections=most)
        assert propagate(graph, chosen).gain[0, 0] == gain


def test_nothing_to_do():
    for scene in (
        HapticScene(),
        HapticScene(SCENE.objects, SCENE.contacts),
        HapticScene(SCENE.objects, (), SCENE.sources),
    ):
        for strategy in Strategy:
            for mode in Mode:
                result = propagate(graph_of_scene(scene), Settings(mode=mode, strategy=strategy))
                assert result.gain.shape == (len(scene.sources), len(scene.listeners))


@pytest.mark.parametrize(
    ("argument", "value"),
    [
        ("threshold", 1.5),
        ("threshold", math.nan),
        ("max_connections", -1),
        ("epsilon", math.inf),
    ],
)
def test_settings_name_what_is_wrong(argument, value):
    with pytest.raises(ValueError, match=f"^{argument}: "):
        Settings(**{argument: value})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"pairs": [[0, 3]]}, "contacts: pairs must be numbers of objects from 0 to 2"),
        ({"pairs": [[-1, 1]]}, "contacts: pairs must be numbers"),
        ({"pairs": [[1, 1]]}, "contacts: 'ground' can't touch itself"),
        ({"positions": [[[0, 0, math.nan], [0, 0, 0]]]}, "contacts: positions must be finite"),
        ({"area": [math.inf]}, "contacts: area must be finite"),
        ({"weight": [1.5]}, "contacts: weight must lie in"),
    ],
)
def test_contacts_name_what_is_wrong(change, message):
    table = ObjectTable.of(SCENE.objects, 0.1)
    contacts = ContactSet.from_contacts(SCENE.contacts, table.index())
    arrays = {key: getattr(contacts, key) for key in ContactSet.__slots__} | {
        key: np.array(value) for key, value in change.items()
    }
    with pytest.raises(ValueError, match=f"^{message}"):
        build_graph(table, ContactSet(**arrays), SCENE.sources, SCENE.listeners)


@pytest.mark.parametrize(
    ("kind", "value"),
    [("sources", Source("s", "moon")), ("listeners", Listener("l", "moon", radius=0.0))],
)
def test_unknown_objects_are_named(kind, value):
    table = ObjectTable.of(SCENE.objects, 0.1)
    ends = {"sources": (), "listeners": (), kind: (value,)}
    with pytest.raises(ValueError, match=f"^{kind}: '.' is on 'moon', but there is no such object"):
        build_graph(table, ContactSet.empty(), ends["sources"], ends["listeners"])


@pytest.mark.parametrize("strategy", list(Strategy))
@pytest.mark.parametrize("formula", ["where(d > 2000, -1, 1)", "where(d > 2000, 1 / (d - d), 1)"])
def test_expression_without_a_gain_is_named(strategy, formula):
    """Farther away than formulas are checked, these are negative, or nothing at all."""
    scene = HapticScene(
        (HapticObject("odd", 0, 1, Expression(expression=formula)),),
        (),
        (Source("s", "odd"),),
        (Listener("l", "odd", (2100, 0, 0), radius=0.0),),
    )
    with pytest.raises(NoGain, match=r"^object 'odd': expression: ") as error:
        propagate(graph_of_scene(scene), Settings(strategy=strategy))
    assert error.value.objects == ("odd",)


@pytest.mark.parametrize("distance", [-1e-9, math.nan, math.inf])
def test_distances_that_are_none(distance):
    table = ObjectTable.of(SCENE.objects, 0.1)
    with pytest.raises(ValueError, match=r"^distance: must be finite and at least 0 m"):
        table.gain(0, np.array([1.0, distance]))


@pytest.mark.parametrize("strategy", list(Strategy))
@pytest.mark.parametrize("far", [1e160, 1e300])
def test_distances_whose_squares_are_no_numbers(strategy, far):
    """Identity carries over them, and nothing else does."""
    for function, gain in ((Identity(), 1.0), (Exponential(alpha=1e-100), 0.0)):
        scene = HapticScene(
            (HapticObject("a", 0, 1, function), HapticObject("b", 0, 1, function)),
            (
                Contact(("a", "b"), ((far, 0, 0), (far, -far, far))),
                Contact(("a", "b"), ((0, 0, far), (0, -far, far))),
            ),
            (Source("s", "a", (-far, far, 0)),),
            (Listener("l", "b", (-far, 0, -far), radius=0.0),),
        )
        result = propagate(graph_of_scene(scene), Settings(strategy=strategy, threshold=0.0))
        if strategy is Strategy.BEST_PATH:
            assert result.gain[0, 0] == gain
        else:
            assert 0 <= result.gain[0, 0] <= 2 * gain


TINY = (
    Constant(gain_value=1e-200),
    Exponential(alpha=1e6),
    Identity(),
    Constant(gain_value=0.6),
    Constant(gain_value=0.0),
)


@pytest.mark.slow
@settings(max_examples=150, deadline=None, derandomize=True)
@given(st.integers(0, 10**6), st.sampled_from(list(Strategy)))
def test_gains_at_the_ends_of_what_numbers_can_say(seed, strategy):
    """Products far below the smallest number, weights next to none: no warning of NumPy, and all
    that is no sum between 0 and 1."""
    scene = connected_scene(
        seed,
        TINY,
        (Constant(gain_value=1e-160), Identity(), Constant(gain_value=0.0)),
        extra=8,
        size=1e4,
        refined=True,
    )
    random = np.random.default_rng(seed)
    contacts = tuple(
        replace(contact, weight=float(random.choice([1.0, 0.5, 1e-300])))
        for contact in scene.contacts
    )
    result = propagate(
        graph_of_scene(replace(scene, contacts=contacts)), Settings(strategy=strategy)
    )
    assert np.isfinite(result.gain).all() and (result.gain >= 0).all()
    if strategy is Strategy.BEST_PATH:
        assert (result.gain <= 1).all()
