"""Statistical energy analysis: conservation, reciprocity, closed forms, and the limits of the documented derivation."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation import energy_balance, propagate
from haptic_tracing.core.propagation.elimination import eliminated
from haptic_tracing.core.scene.functions import Constant, Exponential, Identity, Linear
from haptic_tracing.core.scene.values import Contact, HapticObject, HapticScene, Listener, Settings, Source, Strategy
from hypothesis import given, settings
from hypothesis import strategies as st
from path_reference import METRIC, OTHER, connected_scene

SEEDS = st.integers(0, 10**6)
CHOSEN = Settings(strategy=Strategy.ENERGY_BALANCE)
ORIGIN = (0.0, 0.0, 0.0)


def gain(scene: HapticScene) -> float:
    return float(propagate(graph_of_scene(scene), CHOSEN).gain[0, 0])


def pair_of_objects(a, b, transmission=None) -> HapticScene:
    return HapticScene(
        (HapticObject("a", 0, 1, a), HapticObject("b", 0, 1, b)),
        (Contact(("a", "b"), (ORIGIN, ORIGIN), transmission or Identity()),),
        (Source("s", "a"),),
        (Listener("l", "b"),),
    )


@pytest.mark.parametrize(("a", "b", "t"), [(0.5, 0.5, 1.0), (0.9, 0.1, 0.5), (1.0, 1.0, 1.0), (0.01, 0.02, 0.1)])
def test_two_objects_in_closed_form(a, b, t):
    """E_b = C / (Λ_a Λ_b + C (Λ_a + Λ_b))."""
    scene = pair_of_objects(Constant(gain_value=a), Constant(gain_value=b), Constant(gain_value=t))
    damping_a, damping_b, coupling = 1 / a**2, 1 / b**2, t**2
    energy = coupling / (damping_a * damping_b + coupling * (damping_a + damping_b))
    assert gain(scene) == pytest.approx(math.sqrt(energy), rel=1e-12)


def test_strong_damping_leaves_the_gain_of_the_path():
    """Where little comes back, energy balance and path agree."""
    functions = [Constant(gain_value=0.01)] * 4
    objects = tuple(HapticObject(f"o{i}", 0, 1, function) for i, function in enumerate(functions))
    contacts = tuple(Contact((f"o{i}", f"o{i + 1}"), (ORIGIN, ORIGIN)) for i in range(3))
    scene = HapticScene(objects, contacts, (Source("s", "o0"),), (Listener("l", "o3"),))
    assert gain(scene) == pytest.approx(0.01**4, rel=1e-3)


def test_without_contacts_the_function_itself():
    scene = HapticScene((HapticObject("a", 0.2, 0.9),), (), (Source("s", "a"),), (Listener("l", "a", (2.0, 0, 0)),))
    assert gain(scene) == pytest.approx(0.72 * math.exp(-0.72 * 2), rel=1e-12)


def test_lossless_ring_is_no_trap():
    """Energy that has crossed an object once is spent: a closed ring without losses holds a finite energy."""
    objects = tuple(HapticObject(name, 0, 1, Identity()) for name in "abc")
    ring = tuple(Contact(pair, (ORIGIN, ORIGIN)) for pair in ("ab", "bc", "ca"))
    scene = HapticScene(
        objects, tuple(dataclasses.replace(c, objects=tuple(c.objects)) for c in ring), (Source("s", "a"),), (Listener("l", "b"),)
    )
    assert gain(scene) == pytest.approx(0.5, rel=1e-12)  # Λ = C = 1: 3 E_b = E_a + E_c, E_b = E_c, 3 E_a = 1 + 2 E_b


def test_parts_that_do_not_touch_and_objects_that_block():
    objects = (HapticObject("a", 0.1, 0.9), HapticObject("wall", 1.0, 0.9), HapticObject("b", 0.1, 0.9), HapticObject("far", 0.1, 0.9))
    contacts = (Contact(("a", "wall"), (ORIGIN, ORIGIN)), Contact(("wall", "b"), (ORIGIN, ORIGIN)))
    for listener in ("wall", "b", "far"):
        scene = HapticScene(objects, contacts, (Source("s", "a"),), (Listener("l", listener),))
        assert gain(scene) == 0


@pytest.mark.slow
@settings(max_examples=150, deadline=None, derandomize=True)
@given(SEEDS, st.floats(0.3, 20))
def test_energy_is_conserved_and_never_created(seed, size):
    """The damped energy adds up to the power put in; every coupling gives what it takes; no gain exceeds 1."""
    scene = connected_scene(seed, (*METRIC, *OTHER), size=size, refined=True, extra=5)
    graph = graph_of_scene(scene)
    regions = energy_balance._regions(graph)
    inside = np.minimum(energy_balance._energy_gain(graph, regions.of_object, regions.distance, None), 1.0)
    alive = inside > 0
    damping = 1 / np.where(alive, inside, 1.0)
    rows, columns, coupling, _ = energy_balance._couplings(graph, regions, damping, alive, None)
    matrix = np.zeros((len(damping), len(damping)))
    np.add.at(matrix, (rows, columns), coupling)
    assert np.allclose(matrix, matrix.T, rtol=1e-12, atol=0)
    power = np.zeros((len(damping), len(damping)))
    power[alive, alive] = 1.0
    energy, doubt = energy_balance._solve(damping, rows, columns, coupling, power)
    assert np.allclose(damping @ energy, power.sum(axis=0), rtol=1e-10)
    assert energy.min() >= 0
    assert energy.max(initial=0) <= 1 + 1e-12
    assert np.allclose(energy, energy.T, rtol=1e-9, atol=1e-12)
    result = propagate(graph, CHOSEN)
    assert 0 <= result.gain.min(initial=0) <= result.gain.max(initial=0) <= 1
    assert doubt.max(initial=0) == 0


@pytest.mark.parametrize("seed", range(20))
def test_iterative_solution_within_its_bound(seed, monkeypatch):
    """Elimination and conjugate gradients agree within the bound that the residual gives."""
    random = np.random.default_rng(seed)
    count = 40
    matrix = np.triu(random.uniform(0, 1, (count, count)) * (random.uniform(size=(count, count)) < 0.2), 1)
    matrix = matrix + matrix.T
    rows, columns = np.nonzero(matrix)
    damping = random.uniform(1, 5, count)
    power = random.uniform(0, 1, (count, 3))
    arguments = damping, rows, columns, matrix[rows, columns], power
    exact = np.linalg.solve(np.diag(damping + matrix.sum(axis=1)) - matrix, power)
    assert np.allclose(energy_balance._solve(*arguments)[0], exact, rtol=1e-12, atol=0)
    assert np.allclose(eliminated(*arguments), exact, rtol=1e-12, atol=0)
    for iterations in (1, 3, 2000):
        monkeypatch.setattr(energy_balance, "ITERATIONS", iterations)
        approximate, doubt = energy_balance._iterated(*arguments)
        assert np.all(np.abs(approximate - exact) <= doubt + 1e-14)
    assert doubt.max() < 1e-13


@pytest.mark.parametrize("count", [1, 2, 31, 32, 33, 64, 97, 300])
def test_dense_elimination_against_lapack(count):
    """Also where the last rows and squares are not whole."""
    random = np.random.default_rng(count)
    matrix = np.triu(random.uniform(0, 1, (count, count)), 1)
    matrix = matrix + matrix.T
    rows, columns = np.nonzero(matrix)
    damping, power = random.uniform(1, 5, count), random.uniform(0, 1, (count, 3))
    exact = np.linalg.solve(np.diag(damping + matrix.sum(axis=1)) - matrix, power)
    assert np.allclose(eliminated(damping, rows, columns, matrix[rows, columns], power), exact, rtol=1e-12, atol=0)


@pytest.mark.parametrize("points", [2, 8])
def test_refining_a_patch_changes_nothing(points):
    def scene(count: int) -> HapticScene:
        patch = tuple(Contact(("a", "b"), ((1, 0, 0), (1, 0, 0)), share=1 / count) for _ in range(count))
        other = (Contact(("b", "c"), ((1, 0.5, 0), (1, 0.5, 0))), Contact(("a", "c"), ((0, 0.3, 0), (0, 0.3, 0))))
        objects = tuple(HapticObject(name, 0.2, 0.9) for name in "abc")
        return HapticScene(objects, patch + other, (Source("s", "a"),), (Listener("l", "c", (1, 1, 0)),))

    assert gain(scene(points)) == pytest.approx(gain(scene(1)), rel=1e-12)


def test_large_ground_is_felt_by_distance():
    """Between far ends of a ground that damps over centimetres, less arrives than between near ones."""
    pillars = tuple(HapticObject(f"p{i}", 0.0, 1.0, Identity()) for i in range(20))
    contacts = tuple(Contact(("ground", f"p{i}"), ((float(i), 0, 0), (float(i), 0, 0))) for i in range(20))
    ground = HapticObject("ground", 0, 1, Exponential(alpha=1.0))
    gains = [
        gain(HapticScene((ground, *pillars), contacts, (Source("s", "p0"),), (Listener("l", f"p{i}", (float(i), 0, 1)),)))
        for i in range(1, 20)
    ]
    assert gains == sorted(gains, reverse=True)
    assert gains[-1] < 1e-4


def test_hub_of_10000_contacts_and_special_functions():
    """One object with 10,000 contacts: few regions, a certified answer."""
    count = 10_000
    places = np.random.default_rng(3).uniform(0, 50, (count, 3)) * [1, 1, 0]
    objects = (HapticObject("ground", 0, 1, Linear(range=5.0)), *(HapticObject(f"p{i}", 0.3, 0.9) for i in range(count)))
    contacts = tuple(Contact(("ground", f"p{i}"), (tuple(p), tuple(p))) for i, p in enumerate(places.tolist()))
    scene = HapticScene(objects, contacts, (Source("s", "p0"),), (Listener("l", "p1"), Listener("m", "p0", (1, 1, 1))))
    result = propagate(graph_of_scene(scene), CHOSEN)
    assert (result.gain > 0).all()
    assert (result.error_bound < 1e-6).all()
