"""Materials for wished levels: slopes beside finite differences in many digits, solutions beside
SciPy's, what can't be met."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from haptic_tracing.core.design.wishes import (
    DECIBELS,
    FreeMaterial,
    Wish,
    fulfil,
    log_levels,
    with_changed_k,
)
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.scene.bands import BAND_COUNT
from haptic_tracing.core.scene.coefficients import coefficients_of, transfer_coefficient
from haptic_tracing.core.scene.functions import Constant, HapticTracing, Identity, Physical, Wave
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Settings,
    Source,
)
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares

FUNCTIONS = (
    HapticTracing(),
    Physical(wave=Wave.SURFACE, loss_factor=0.2, phase_speed=200.0, material_k=0.3),
    Physical(wave=Wave.PLATE, loss_factor=0.1, phase_speed=3000.0, thickness=0.02),
    Physical(loss_factor=1e-4, phase_speed=5000.0),
)


def chain(seed: int, functions=FUNCTIONS, count: int = 4) -> HapticScene:
    """Objects in a row, of random ones of the functions, with a listener on each; the first carries
    two sources."""
    generator = np.random.default_rng(seed)
    objects = tuple(
        HapticObject(
            f"o{i}",
            *generator.uniform(0.2, 0.8, 2).tolist(),
            functions[generator.integers(len(functions))],
        )
        for i in range(count)
    )
    at = np.cumsum(generator.uniform(0.3, 1.2, count + 1)).tolist()
    contacts = tuple(
        Contact(
            (f"o{i}", f"o{i + 1}"),
            ((at[i + 1], 0.0, 0.0),) * 2,
            Constant(gain_value=0.8) if i % 2 else Identity(),
        )
        for i in range(count - 1)
    )
    sources = (Source("s", "o0", (at[0], 0.0, 0.0)), Source("t", "o0", (at[0], 0.5, 0.0)))
    listeners = tuple(Listener(f"l{i}", f"o{i}", (at[i + 1], 0.1, 0.0)) for i in range(count))
    return HapticScene(objects, contacts, sources, listeners)


def energies(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0.1, 1.0, (2, BAND_COUNT))


@pytest.mark.parametrize("seed", range(5))
def test_slopes_are_finite_differences(seed):
    graph = graph_of_scene(chain(seed))
    found = log_levels(graph, Settings(), energies(seed))
    step = 1e-5
    for number in range(4):
        up, down = (
            log_levels(
                with_changed_k(graph, [[number]], np.array([sign * step])),
                Settings(),
                energies(seed),
            ).level
            for sign in (1, -1)
        )
        assert found.slope[:, number] == pytest.approx((up - down) / (2 * step), abs=2e-7)


@pytest.mark.parametrize("k", [0.05, 0.3, 0.9])
def test_slopes_of_functions_in_many_digits(k):
    """d ln g / d ln K of the paper's function and of damping by measurement, by mpmath's own
    differentiation."""
    d, mpmath.mp.dps = 1.7, 40
    paper = mpmath.diff(lambda u: u - max(mpmath.exp(u), mpmath.mpf("0.1")) * d, mpmath.log(k))
    assert HapticTracing().slopes(d, 1 - k, 1.0, 0.1) == pytest.approx(
        [float(paper)] * BAND_COUNT, rel=1e-12
    )
    function = FUNCTIONS[1]
    for band, centre in enumerate(
        np.sqrt(np.array([20, 40, 80, 160, 320, 640]) * np.array([40, 80, 160, 320, 640, 1000]))
    ):
        alpha = mpmath.pi * centre * function.loss_factor / function.phase_speed
        measured = mpmath.diff(
            lambda u, alpha=alpha: -alpha * u / mpmath.log(function.material_k) * d, mpmath.log(k)
        )
        assert function.slopes(d, 1 - k, 1.0, 0.1)[band] == pytest.approx(
            float(measured), rel=1e-12
        )


@pytest.mark.parametrize("seed", range(5))
def test_wishes_are_met_as_well_as_scipy_meets_them(seed):
    """Where the logarithms are nearly linear, so that there is one minimum: damping as measured."""
    graph, generator = graph_of_scene(chain(seed, FUNCTIONS[1:])), np.random.default_rng(seed)
    groups = [[0], [1], [2, 3]]
    start = np.log(
        [transfer_coefficient(o.kappa, o.rho) for o in (graph.table.objects[g[0]] for g in groups)]
    )
    low, high = np.log(0.05) - start, np.log(0.9) - start
    free = [FreeMaterial(tuple(f"o{i}" for i in g), 0.05, 0.9) for g in groups]
    wished = generator.uniform(-3, 3, 3)
    before = log_levels(graph, Settings(), energies(seed)).level[1:]

    def changes(x):
        return (
            log_levels(with_changed_k(graph, groups, x), Settings(), energies(seed)).level[1:]
            - before
        ) * DECIBELS

    answer = fulfil(
        graph,
        Settings(),
        energies(seed),
        [Wish(f"l{i + 1}", float(w)) for i, w in enumerate(wished)],
        free,
    )
    expected = least_squares(
        lambda x: wished - changes(x),
        np.clip(0, low, high),
        bounds=(low - 1e-9, high + 1e-9),
        xtol=1e-12,
    )
    assert np.sum((np.array(answer.changes) - wished) ** 2) == pytest.approx(
        2 * expected.cost, abs=0.01
    )
    assert np.all((np.array(answer.k) > 0.05 - 1e-9) & (np.array(answer.k) < 0.9 + 1e-9))
    assert changes(np.log(answer.k) - start) == pytest.approx(np.array(answer.changes), abs=1e-9)


def test_a_wish_within_reach_is_met_to_a_tenth_of_a_decibel():
    scene = chain(3, (HapticTracing(),))
    answer = fulfil(
        graph_of_scene(scene),
        Settings(),
        energies(3),
        [Wish("l3", -8.0)],
        [FreeMaterial(("o1",)), FreeMaterial(("o2",))],
    )
    assert answer.changes == pytest.approx((-8.0,), abs=0.1)


def test_what_nothing_free_can_change_is_not_reported_as_met():
    scene = HapticScene(
        (HapticObject("a", 0.5, 0.9, Constant(gain_value=0.5)), HapticObject("b", 0.5, 0.9)),
        (),
        (Source("s", "a"),),
        (Listener("near", "a", (1.0, 0.0, 0.0)), Listener("elsewhere", "b")),
    )
    wishes = [Wish("near", 6.0), Wish("elsewhere", 6.0)]
    answer = fulfil(
        graph_of_scene(scene), Settings(), np.ones((1, BAND_COUNT)), wishes, [FreeMaterial(("a",))]
    )
    assert answer.changes[0] == pytest.approx(0.0, abs=1e-12)
    assert np.isnan(answer.changes[1])


@given(st.floats(0, 1), st.floats(0, 1))
def test_kappa_and_rho_of_a_coefficient(k, rho):
    kappa, new = coefficients_of(k, rho)
    assert transfer_coefficient(kappa, new) == pytest.approx(k, abs=1e-15)
    assert 0 <= kappa <= 1 and 0 <= new <= 1
    assert new == rho or rho < k
