"""Rounding errors, judged by mpmath from the same inputs: relative error below 1e-12 wherever the
answer is above 1e-300."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from functools import cache

import mpmath
import numpy as np
import pytest
from haptic_tracing.core.graph.haptic_graph import HapticGraph, graph_of_scene
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.bands import BAND_CENTRES
from haptic_tracing.core.scene.functions import (
    Constant,
    Exponential,
    HapticTracing,
    Identity,
    Physical,
    Wave,
)
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Mode,
    Settings,
    Source,
    Strategy,
    Vector,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from path_reference import connected_scene, recursive_paths

PAPER = Settings(Mode.HT, Strategy.AS_IN_THE_PAPER, None, 0.0)
LEAST = 1e-6
"""Gain at which the search for the best path ends."""
LONG, KAPPA = 3_000, 1.11e-3
SEEDS = st.integers(0, 10**6)


def physical_gain(
    function: Physical, k: mpmath.mpf, distance: mpmath.mpf, sizes: list[mpmath.mpf]
) -> mpmath.mpf:
    """Spreading by the areas of fronts, which begin with the sizes of patches and end where the
    body is filled; damping at the centre of the lowest band, scaled by ln K / ln K0; and the factor
    min(1, K / K0)."""
    if k <= 0:
        return mpmath.mpf(0)
    radius, thickness, extent, speed = map(
        mpmath.mpf,
        (
            function.reference_distance,
            function.thickness,
            function.extent,
            function.phase_speed,
        ),
    )
    frequency = mpmath.mpf(BAND_CENTRES[0])
    filled = radius + extent
    if function.wave is Wave.BOUNDED:
        filled = max(radius, extent)
        speed = min(speed, 2 * mpmath.sqrt(mpmath.mpf(1.8) * speed * thickness * frequency))
    damping = mpmath.pi * frequency * mpmath.mpf(function.loss_factor) / speed
    damping *= mpmath.log(k) / mpmath.log(mpmath.mpf(function.material_k))

    def area(size: mpmath.mpf) -> mpmath.mpf:
        deep = function.wave is Wave.BOUNDED and thickness > radius
        return size * min(size, thickness) if deep else size

    ends = [max(radius, size) for size in sizes]
    largest = max(*ends, min(distance + sum(ends) / 2, filled))
    spread = mpmath.sqrt(area(ends[0]) * area(ends[1])) / area(largest)
    dial = min(1, k / mpmath.mpf(function.material_k))
    return dial * mpmath.exp(-damping * distance) * mpmath.sqrt(spread)


def exact_gain(
    graph: HapticGraph, areas: Mapping[tuple[str, Vector], float], a: int, b: int
) -> mpmath.mpf:
    """Gain of a connection from the authored numbers alone; ``areas``: of patches by object and
    place."""
    place = [[mpmath.mpf(x) for x in graph.node_position[node].tolist()] for node in (a, b)]
    distance = mpmath.sqrt(sum((x - y) ** 2 for x, y in zip(*place, strict=True)))
    if graph.partner[a] == b:
        return mpmath.exp(-mpmath.mpf(float(graph.crossing_costs()[a])))
    item = graph.table.objects[graph.node_object[a]]
    if isinstance(item.propagation, Exponential):
        return mpmath.exp(-mpmath.mpf(item.propagation.alpha) * distance)
    if isinstance(item.propagation, Identity):
        return mpmath.mpf(1)
    if isinstance(item.propagation, Constant):
        return mpmath.mpf(item.propagation.gain_value)
    k = (1 - mpmath.mpf(item.kappa)) * mpmath.mpf(item.rho)
    if isinstance(item.propagation, Physical):
        sizes = [
            mpmath.sqrt(areas.get((item.name, tuple(graph.node_position[node].tolist())), 0.0))
            for node in (a, b)
        ]
        return physical_gain(item.propagation, k, distance, sizes)
    return k * mpmath.exp(-max(k, mpmath.mpf(graph.table.epsilon)) * distance)


def exact_path(graph: HapticGraph, scene: HapticScene, path: tuple[int, ...]) -> mpmath.mpf:
    areas = {
        (name, place): contact.area
        for contact in scene.contacts
        for name, place in zip(contact.objects, contact.positions, strict=True)
    }
    product = mpmath.mpf(1)
    for a, b in itertools.pairwise(path):
        product *= exact_gain(graph, areas, a, b)
    return product


def close(got: float, exact: mpmath.mpf, tolerance: float = 1e-12) -> bool:
    return exact < 1e-300 or abs(mpmath.mpf(got) - exact) <= tolerance * exact


@pytest.mark.slow
@settings(max_examples=60, deadline=None, derandomize=True)
@given(SEEDS, st.sampled_from([1e-9, 1.0, 30.0]), st.sampled_from([0.0, 1e9]))
def test_random_scenes(seed, size, offset):
    """Small and large scenes, also far from the origin."""
    scene = connected_scene(seed, size=size, extra=3, most_objects=6)
    shifted = HapticScene(
        scene.objects,
        tuple(
            Contact(
                c.objects,
                tuple(tuple(x + offset for x in p) for p in c.positions),
                c.transmission,
                area=c.area,
                share=c.share,
            )
            for c in scene.contacts
        ),
        scene.sources,
        scene.listeners,
    )
    with mpmath.workdps(40):
        graph = graph_of_scene(shifted)
        best = propagate(graph, Settings())
        total = propagate(graph, PAPER)
        for column in range(len(graph.listeners)):
            gains = [
                exact_path(graph, shifted, path) for path, _ in recursive_paths(graph, 0, column)
            ]
            largest = max(gains, default=mpmath.mpf(0))
            assert close(best.gain[0, column], largest if largest >= LEAST else mpmath.mpf(0))
            assert close(total.gain[0, column], mpmath.fsum(gains))


@cache
def contacts_in_a_row(count: int) -> tuple[Contact, ...]:
    """Of every object with the next one, all in one place."""
    origin = (0.0, 0.0, 0.0)
    return tuple(Contact((f"{i:06d}", f"{i + 1:06d}"), (origin, origin)) for i in range(count - 1))


def chain(count: int, function, kappa: float = 0.0) -> HapticScene:
    """Objects in a row."""
    objects = tuple(HapticObject(f"{i:06d}", kappa, 1.0, function) for i in range(count))
    return HapticScene(
        objects,
        contacts_in_a_row(count),
        (Source("s", "000000"),),
        (Listener("l", f"{count - 1:06d}", radius=0.0),),
    )


@pytest.fixture(scope="module")
def chain_of_gains_near_one():
    return graph_of_scene(chain(LONG, HapticObject("x", 0, 1).propagation, KAPPA))


@pytest.mark.slow
def test_chain_of_3000_objects():
    """Gains close to 1, so that the answer is not tiny."""
    result = propagate(graph_of_scene(chain(LONG, HapticTracing(), KAPPA)), Settings())
    with mpmath.workdps(40):
        exact = (1 - mpmath.mpf(KAPPA)) ** LONG
        assert exact > 1e-2
        assert close(result.gain[0, 0], exact)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    st.lists(st.tuples(st.integers(0, 10**6), st.floats(0, 1)), min_size=2, max_size=40),
    st.floats(0, 1e9),
    st.floats(0, 1e-9),
)
def test_values_at_the_ends_of_their_ranges(parts, far, near):
    """kappa = 1, rho = 0, epsilon = 0, nodes that coincide, 1e9 m and 1e-9 m: finite, in [0, 1],
    and a blocked way is 0 and no path."""
    objects = tuple(
        HapticObject(f"o{i}", [0.0, 1.0, value][seed % 3], [1.0, 0.0, 1 - value][seed // 3 % 3])
        for i, (seed, value) in enumerate(parts)
    )
    spots = [(0.0, 0.0, 0.0), (far, 0.0, 0.0), (0.0, near, -far)]
    contacts = tuple(
        Contact((f"o{i}", f"o{i + 1}"), (spots[seed % 3], spots[seed // 3 % 3]))
        for i, (seed, _) in enumerate(parts[:-1])
    )
    scene = HapticScene(
        objects,
        contacts,
        (Source("s", "o0"),),
        (Listener("l", f"o{len(parts) - 1}", (far, near, 0), radius=0.0),),
        Settings(epsilon=0.0),
    )
    graph = graph_of_scene(scene)
    blocked = any(item.kappa == 1 or item.rho == 0 for item in objects)
    for strategy in Strategy:
        result = propagate(graph, Settings(strategy=strategy, epsilon=0.0))
        assert 0 <= result.gain[0, 0] <= 1
        if blocked:
            assert result.gain[0, 0] == 0
            assert not result.best_path


@pytest.mark.slow
def test_10000_contacts_on_one_object():
    """A ground with 10,000 pebbles and two benches: what a pebble leads to is nothing, and what the
    bench receives is exact."""
    pebbles = 10_000
    random = np.random.default_rng(7)
    places = random.uniform(-5, 5, (pebbles, 3)).tolist()
    objects = [HapticObject("ground", 0.2, 0.9), HapticObject("bench", 0.1, 0.8)] + [
        HapticObject(f"p{i}", 0, 1) for i in range(pebbles)
    ]
    contacts = [Contact(("ground", f"p{i}"), (tuple(p), tuple(p))) for i, p in enumerate(places)]
    contacts += [Contact(("ground", "bench"), ((x, 0, 0), (x, 0, 0))) for x in (1.0, 1.5)]
    scene = HapticScene(
        tuple(objects),
        tuple(contacts),
        (Source("s", "ground"),),
        (Listener("l", "bench", (1.25, 0, 0.5), radius=0.0),),
    )
    graph = graph_of_scene(scene)
    with mpmath.workdps(40):
        kept = graph_of_scene(
            HapticScene(tuple(objects[:2]), tuple(contacts[-2:]), scene.sources, scene.listeners)
        )
        gains = [exact_path(kept, scene, path) for path, _ in recursive_paths(kept, 0, 0)]
        assert close(propagate(graph, Settings()).gain[0, 0], max(gains))
        assert close(
            propagate(graph, PAPER).gain[0, 0],
            mpmath.fsum(gains),
        )


def test_gains_within_one_unit_in_the_last_place_of_each_other():
    """Two ways whose gains differ in the last digit, or not at all: either may be taken, the gain
    is right to the last digits."""
    for gain in (0.7, math.nextafter(0.7, 1), math.nextafter(0.7, 0)):
        objects = (
            HapticObject("a", 0, 1, Identity()),
            HapticObject("b", 0, 1, Constant(gain_value=0.7)),
            HapticObject("c", 0, 1, Constant(gain_value=gain)),
            HapticObject("d", 0, 1, Identity()),
        )
        origin = (0.0, 0.0, 0.0)
        contacts = tuple(
            Contact(pair, (origin, origin))
            for pair in (("a", "b"), ("b", "d"), ("a", "c"), ("c", "d"))
        )
        scene = HapticScene(
            objects, contacts, (Source("s", "a"),), (Listener("l", "d", radius=0.0),)
        )
        graph = graph_of_scene(scene)
        assert propagate(graph, Settings()).gain[0, 0] == pytest.approx(max(0.7, gain), rel=1e-15)
        assert propagate(graph, PAPER).gain[0, 0] == pytest.approx(0.7 + gain, rel=1e-15)
