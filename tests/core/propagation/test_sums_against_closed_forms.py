"""Sums over all paths, and best paths, whose values are known in closed form."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation import Propagation, objects_on, propagate
from haptic_tracing.core.scene.functions import Constant, Exponential, HapticTracing, Identity
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Settings,
    Source,
    Strategy,
)

ONE = Identity()
ORIGIN = (0.0, 0.0, 0.0)


def scene_of(edges, functions, source, listeners, transmission=ONE) -> HapticScene:
    """Objects by number, each with a function; all nodes at the origin."""
    return HapticScene(
        tuple(HapticObject(f"{i:06d}", 0.0, 1.0, function) for i, function in enumerate(functions)),
        tuple(Contact((f"{a:06d}", f"{b:06d}"), (ORIGIN, ORIGIN), transmission) for a, b in edges),
        (Source("s", f"{source:06d}"),),
        tuple(Listener(f"l{k}", f"{o:06d}", radius=0.0) for k, o in enumerate(listeners)),
    )


def run(scene: HapticScene, strategy: Strategy = Strategy.AS_IN_THE_PAPER, **limits) -> Propagation:
    chosen = {"max_connections": None, "threshold": 0.0, **limits}
    return propagate(graph_of_scene(scene), Settings(strategy=strategy, **chosen))


def grid(rows: int, columns: int) -> list[tuple[int, int]]:
    number = {(i, j): j * rows + i for i in range(rows) for j in range(columns)}
    down = [(number[i, j], number[i + 1, j]) for i in range(rows - 1) for j in range(columns)]
    return down + [
        (number[i, j], number[i, j + 1]) for i in range(rows) for j in range(columns - 1)
    ]


def test_ladder_with_losses_against_its_transfer_matrix():
    """Through every column, crossing a rung or not: with gain g inside and t between, each of the n
    - 1 steps multiplies the state (at this row, at the other one) by one matrix."""
    g, t, n = Fraction(7, 10), Fraction(9, 10), 8
    scene = scene_of(
        grid(2, n),
        [Constant(gain_value=0.7)] * (2 * n),
        0,
        [2 * n - 2, 2 * n - 1],
        Constant(gain_value=0.9),
    )
    # Within a column: straight through (g), or over the rung (g t g). The last column ends at the
    # listener.
    straight, over = g, g * t * g
    same, other = Fraction(1), Fraction(0)
    for _ in range(n - 1):
        same, other = t * (same * straight + other * over), t * (same * over + other * straight)
    exact = same * straight + other * over, same * over + other * straight
    result = run(scene)
    for got, expected in zip(result.gain[0].tolist(), exact, strict=True):
        assert got == pytest.approx(float(expected), rel=1e-12)


def trails(edges: list[tuple[int, int]], start: int, end: int) -> int:
    """The number of ways from ``start`` to ``end`` that use no edge twice."""
    count = int(start == end)
    for k, edge in enumerate(edges):
        if start in edge:
            count += trails(edges[:k] + edges[k + 1 :], sum(edge) - start, end)
    return count


@pytest.mark.parametrize(("rows", "columns"), [(2, 2), (3, 3), (3, 4)])
def test_walls_without_losses_have_as_many_paths_as_trails(rows, columns):
    """A path crosses no contact twice."""
    last = rows * columns - 1
    result = run(scene_of(grid(rows, columns), [ONE] * (last + 1), 0, [last]))
    assert result.gain[0, 0] == result.paths[0, 0] == trails(grid(rows, columns), 0, last)
    assert not result.limited[0, 0]


@pytest.mark.parametrize("arches", [1, 2, 3, 5])
def test_ground_with_arches(arches):
    """k of m arches in any order, either way round: m! / (m - k)! 2^k paths, each through k arches
    and k + 1 times through the ground."""
    ground, arch = 0.5, 0.4
    edges = [(0, i) for i in range(1, arches + 1) for _ in range(2)]
    result = run(
        scene_of(
            edges, [Constant(gain_value=ground)] + [Constant(gain_value=arch)] * arches, 0, [0]
        )
    )
    expected = sum(
        math.perm(arches, k) * 2**k * ground ** (k + 1) * arch**k for k in range(arches + 1)
    )
    assert result.gain[0, 0] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("limit", [1, 3, 5, 9, 13])
def test_ground_with_arches_and_limited_connections(limit):
    """Each arch costs two contacts: k arches make 4 k + 1 connections."""
    edges = [(0, i) for i in range(1, 6) for _ in range(2)]
    result = run(scene_of(edges, [Constant(gain_value=0.9)] * 6, 0, [0]), max_connections=limit)
    expected = sum(
        math.perm(5, k) * 2**k * 0.9 ** (2 * k + 1) for k in range(6) if 4 * k + 1 <= limit
    )
    assert result.gain[0, 0] == pytest.approx(expected, rel=1e-12)


def test_bridges_multiply():
    """Two rings joined by a bridge: the sum is the product of both."""
    ring = [(0, 1), (1, 2), (2, 0)]
    edges = ring + [(2, 3)] + [(a + 3, b + 3) for a, b in ring]
    g = 0.6
    functions = [Constant(gain_value=g)] * 6
    both = run(scene_of(edges, functions, 0, [5])).gain[0, 0]
    to_bridge = run(scene_of([*ring, (2, 3)], functions[:4], 0, [3])).gain[0, 0] / g
    from_bridge = (
        run(scene_of([(0, 1), *((a + 1, b + 1) for a, b in ring)], functions[:4], 0, [3])).gain[
            0, 0
        ]
        / g
    )
    assert both == pytest.approx(to_bridge * from_bridge, rel=1e-12)


@pytest.mark.parametrize("strategy", list(Strategy))
@pytest.mark.parametrize("points", [2, 5])
def test_refining_a_patch_changes_no_total(strategy, points):
    """A ring of three with one patch given as several points at its place: paths cross it once."""

    def scene(count: int) -> HapticScene:
        objects = tuple(HapticObject(name, 0.3, 0.9) for name in "abc")
        patch = tuple(
            Contact(("a", "b"), ((1, 0, 0), (1, 0, 0)), share=1 / count) for _ in range(count)
        )
        others = (
            Contact(("b", "c"), ((1, 1, 0), (1, 1, 0))),
            Contact(("c", "a"), ((0, 1, 0), (0, 1, 0))),
        )
        return HapticScene(
            objects,
            patch + others,
            (Source("s", "a"),),
            (
                Listener("l", "a", (0.3, 0, 0), radius=0.0),
                Listener("m", "b", (2, 0, 0), radius=0.0),
            ),
        )

    whole, refined = run(scene(1), strategy), run(scene(points), strategy)
    assert refined.gain[0].tolist() == pytest.approx(whole.gain[0].tolist(), rel=1e-12)
    limited = (
        run(scene(1), strategy, max_connections=9, threshold=1e-3),
        run(scene(points), strategy, max_connections=9, threshold=1e-3),
    )
    assert limited[1].gain[0].tolist() == pytest.approx(limited[0].gain[0].tolist(), rel=1e-12)


def test_pebble_changes_nothing():
    """What lies on the ground without leading anywhere is on no path."""
    objects = (
        HapticObject("ground", 0.2, 0.9),
        HapticObject("bench", 0.1, 0.8),
        HapticObject("pebble", 0.0, 1.0),
    )
    feet = tuple(Contact(("ground", "bench"), ((x, 0, 0), (x, 0, 0))) for x in (1.0, 2.0))
    pebble = Contact(("pebble", "ground"), ((0.5, 0, 0), (0.5, 0, 0)))
    ends = (Source("s", "ground"),), (Listener("l", "bench", (1.5, 0, 0.5), radius=0.0),)
    for strategy in Strategy:
        with_it = run(HapticScene(objects, (*feet, pebble), *ends), strategy)
        without = run(HapticScene(objects, feet, *ends), strategy)
        assert with_it.gain.tolist() == without.gain.tolist()


def test_path_may_use_a_rail_that_carries_further_than_soil():
    """Ground, rail, ground: the best path leaves the ground and comes back."""
    objects = (
        HapticObject("soil", 0.0, 1.0, Exponential(alpha=1.0)),
        HapticObject("steel", 0.0, 1.0, Exponential(alpha=0.01)),
    )
    sleepers = tuple(Contact(("soil", "steel"), ((x, 0, 0), (x, 0, 0))) for x in (1.0, 9.0))
    scene = HapticScene(
        objects,
        sleepers,
        (Source("s", "soil"),),
        (Listener("l", "soil", (10.0, 0, 0), radius=0.0),),
    )
    result = run(scene, Strategy.BEST_PATH)
    assert result.gain[0, 0] == pytest.approx(math.exp(-1 - 0.08 - 1), rel=1e-12)
    assert objects_on(graph_of_scene(scene), result.best_path[0, 0]) == ("soil", "steel", "soil")


def test_source_on_both_sides_of_its_contact():
    """An impact feeds both objects: the best of both ways, or the sum of all."""
    objects = (
        HapticObject("a", 0.5, 1.0, HapticTracing()),
        HapticObject("b", 0.2, 1.0, HapticTracing()),
    )
    contact = Contact(("a", "b"), (ORIGIN, ORIGIN))
    source = Source("impact", "a", ORIGIN, second_object="b")
    scene = HapticScene(
        objects, (contact,), (source,), (Listener("l", "b", (1, 0, 0), radius=0.0),)
    )
    direct = 0.8 * math.exp(-0.8)
    through = 0.5 * direct
    assert run(scene, Strategy.BEST_PATH).gain[0, 0] == pytest.approx(direct, rel=1e-12)
    assert run(scene, Strategy.AS_IN_THE_PAPER).gain[0, 0] == pytest.approx(
        direct + through, rel=1e-12
    )


def test_threshold_that_is_met_exactly_goes_on():
    """0.1 three times over is 1/1000, whatever its binary digits make of it."""
    scene = scene_of([(0, 1), (1, 2)], [Constant(gain_value=0.1)] * 3, 0, [2])
    assert run(scene, threshold=0.001).gain[0, 0] == pytest.approx(1e-3, rel=1e-12)
    assert run(scene, threshold=0.001 * (1 + 1e-9)).gain[0, 0] == 0
    halves = scene_of([(i, i + 1) for i in range(9)], [Constant(gain_value=0.5)] * 10, 0, [9])
    assert run(halves, threshold=2.0**-10).gain[0, 0] == 2.0**-10


@pytest.mark.parametrize("threshold", [0.0, 1e-3])
def test_a_source_that_nothing_joins_to_a_listener(threshold):
    """Beside one that has a path, in a scene with cycles and in one without contacts."""
    objects = tuple(HapticObject(name, 0.3, 0.9) for name in "abcd")
    ring = tuple(
        Contact(pair, ((1, 0, 0), (1, 0, 0))) for pair in (("a", "b"), ("b", "c"), ("c", "a"))
    )
    ends = (Source("s", "a"), Source("alone", "d")), (Listener("l", "b", (2, 0, 0), radius=0.0),)
    for contacts in (ring, ()):
        result = run(HapticScene(objects, contacts, *ends), threshold=threshold)
        assert (result.gain[0, 0] > 0) == bool(contacts) and result.gain[1, 0] == 0
