"""What must not matter: the order of anything, which end is the source, where the scene stands."""

from __future__ import annotations

import dataclasses
from random import Random

import numpy as np
import pytest
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation import objects_on, propagate
from haptic_tracing.core.scene.values import HapticScene, Listener, Mode, Settings, Source, Strategy
from hypothesis import given, settings
from hypothesis import strategies as st
from path_reference import METRIC, OTHER, connected_scene

SEEDS = st.integers(0, 10**6)
STRATEGIES = st.sampled_from(list(Strategy))
LIMITS = st.sampled_from([(None, 0.0), (32, 1e-3), (9, 0.0), (None, 1e-2)])


def several_sources(scene: HapticScene, seed: int) -> HapticScene:
    random = Random(seed)
    names = [item.name for item in scene.objects]
    sources = tuple(
        Source(
            f"s{k}",
            random.choice(names),
            (random.random(), random.random(), 0.0),
            kind=random.choice(["persistent", "temporary"]),
        )
        for k in range(random.randint(1, 4))
    )
    return dataclasses.replace(scene, sources=sources)


@pytest.mark.slow
@settings(max_examples=120, deadline=None, derandomize=True)
@given(SEEDS, STRATEGIES, LIMITS, st.sampled_from(list(Mode)))
def test_order_of_input_bit_by_bit(seed, strategy, limits, mode):
    scene = several_sources(
        connected_scene(seed, (*METRIC, *OTHER), listeners=4, refined=True), seed
    )
    random = Random(seed + 1)

    def shuffled(items):
        return tuple(random.sample(list(items), len(items)))

    contacts = tuple(
        dataclasses.replace(
            c,
            objects=c.objects[::-1],
            positions=c.positions[::-1],
            normal=tuple(-x for x in c.normal),
        )
        if random.random() < 0.5
        else c
        for c in shuffled(scene.contacts)
    )
    other = HapticScene(
        shuffled(scene.objects), contacts, shuffled(scene.sources), shuffled(scene.listeners)
    )
    chosen = Settings(mode=mode, strategy=strategy, max_connections=limits[0], threshold=limits[1])
    graphs = graph_of_scene(scene), graph_of_scene(other)
    results = [propagate(graph, chosen) for graph in graphs]
    for row, source in enumerate(scene.sources):
        for column, listener in enumerate(scene.listeners):
            here = row, column
            there = other.sources.index(source), other.listeners.index(listener)
            assert results[0].gain[here] == results[1].gain[there]
            assert results[0].limited[here] == results[1].limited[there]
            assert results[0].paths[here] == results[1].paths[there]
            paths = [
                objects_on(graph, result.best_path.get(pair, ()))
                for graph, result, pair in zip(graphs, results, (here, there), strict=True)
            ]
            assert paths[0] == paths[1]


@pytest.mark.slow
@settings(max_examples=120, deadline=None, derandomize=True)
@given(SEEDS, STRATEGIES, LIMITS)
def test_source_and_listener_exchanged(seed, strategy, limits):
    scene = connected_scene(seed, (*METRIC[:3], *OTHER), listeners=1, refined=True)
    source, listener = (
        dataclasses.replace(scene.sources[0], second_object=None, second_position=None),
        scene.listeners[0],
    )
    forth = dataclasses.replace(scene, sources=(source,))
    back = dataclasses.replace(
        scene,
        sources=(Source("s", listener.object, listener.position),),
        listeners=(Listener("l", source.object, source.position, radius=0.0),),
    )
    chosen = Settings(strategy=strategy, max_connections=limits[0], threshold=limits[1])
    gains = [propagate(graph_of_scene(each), chosen).gain[0, 0] for each in (forth, back)]
    assert gains[0] == pytest.approx(gains[1], rel=1e-12, abs=1e-15)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(SEEDS, STRATEGIES, st.integers(0, 3))
def test_more_listeners_change_nothing(seed, strategy, extra):
    """Listeners feel, they do not absorb."""
    scene = connected_scene(seed, METRIC[:3], listeners=1, extra=3)
    random = Random(seed)
    more = tuple(
        Listener(
            f"m{k}",
            random.choice(scene.objects).name,
            (random.random(), random.random(), random.random()),
            radius=0.0,
        )
        for k in range(extra)
    )
    chosen = Settings(strategy=strategy, max_connections=None, threshold=0.0)
    alone = propagate(graph_of_scene(scene), chosen)
    together = propagate(
        graph_of_scene(dataclasses.replace(scene, listeners=(*scene.listeners, *more))), chosen
    )
    assert together.gain[0, 0] == pytest.approx(alone.gain[0, 0], rel=1e-12)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(SEEDS, STRATEGIES)
def test_scene_moved_by_a_power_of_two(seed, strategy):
    """A shift that is exact in binary leaves every distance as it is."""
    scene = connected_scene(seed, METRIC[:3], listeners=2)

    def rounded(place):
        return tuple(round(x * 2**20) / 2**20 for x in place)

    def at(offset: float) -> HapticScene:
        def moved(place):
            return tuple(x + offset for x in rounded(place))

        return HapticScene(
            scene.objects,
            tuple(
                dataclasses.replace(c, positions=tuple(map(moved, c.positions)))
                for c in scene.contacts
            ),
            tuple(Source("s", s.object, moved(s.position)) for s in scene.sources),
            tuple(
                Listener(k.name, k.object, moved(k.position), radius=0.0) for k in scene.listeners
            ),
        )

    chosen = Settings(strategy=strategy)
    here, there = (propagate(graph_of_scene(at(offset)), chosen).gain for offset in (0.0, 1024.0))
    assert np.allclose(here, there, rtol=1e-9, atol=1e-12)
    assert here.tolist() == there.tolist()
