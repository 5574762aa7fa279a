"""Mixing methods against their formulas, written out sample by sample."""

from __future__ import annotations

import math

import numpy as np
import pytest
from haptic_tracing.core.formats.io.error import FormatError
from haptic_tracing.core.formats.scene.scene_json import scene_from_dict
from haptic_tracing.core.message import sentence
from haptic_tracing.core.render.mixdown import listener_mixes
from haptic_tracing.core.render.mixing import (
    MixingExpression,
    check_mixing,
    cumulative,
    mixed,
    power,
    saturated,
    strongest,
    weighted,
)
from haptic_tracing.core.render.renderer import ListenerMix, Renderer
from haptic_tracing.core.render.voices import Voice
from haptic_tracing.core.scene.functions import MIXING_VARIABLES
from haptic_tracing.core.scene.values import Listener
from haptic_tracing.core.signals import Constant, Decay, Sine
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

samples = arrays(
    np.float64,
    st.tuples(st.integers(0, 5), st.integers(1, 8)),
    elements=st.floats(-1e6, 1e6, allow_subnormal=False),
)
limits = st.floats(1e-3, 1e7)


def held(total: float, s_max: float) -> float:
    """The paper's equation for one sample."""
    return total if abs(total) <= s_max else total / abs(total) * s_max


@given(samples, limits)
@settings(deadline=None)
def test_cumulative(signals: np.ndarray, s_max: float) -> None:
    expected = [held(math.fsum(column), s_max) for column in signals.T]
    assert saturated(cumulative(signals), s_max) == pytest.approx(expected, rel=1e-12, abs=1e-8)


@given(samples, limits, st.data())
@settings(deadline=None)
def test_weighted(signals: np.ndarray, s_max: float, data: st.DataObject) -> None:
    weights = data.draw(arrays(np.float64, len(signals), elements=st.floats(0, 10)))
    expected = [
        held(math.fsum(w * s for w, s in zip(weights, column, strict=True)), s_max)
        for column in signals.T
    ]
    assert saturated(weighted(signals, weights), s_max) == pytest.approx(
        expected, rel=1e-12, abs=1e-7
    )


@given(samples, limits)
@settings(deadline=None)
def test_strongest(signals: np.ndarray, s_max: float) -> None:
    expected = [held(max(column, key=abs, default=0.0), s_max) for column in signals.T.tolist()]
    assert saturated(strongest(signals), s_max).tolist() == pytest.approx(expected)


@given(samples, limits)
@settings(deadline=None)
def test_power(signals: np.ndarray, s_max: float) -> None:
    result = saturated(power(signals), s_max)
    for value, column in zip(result, signals.T, strict=True):
        magnitude = math.hypot(*column)
        assert abs(value) == pytest.approx(min(magnitude, s_max), rel=1e-9, abs=1e-150)
        total = math.fsum(column)
        if abs(total) > 1e-6 * magnitude and magnitude > 1e-100:
            assert np.sign(value) == np.sign(total)
    unlimited = power(signals)
    assert (
        np.abs(unlimited) >= np.abs(signals).max(axis=0, initial=0.0) * (1 - 1e-9) - 1e-150
    ).all()
    assert (np.abs(unlimited) <= np.abs(signals).sum(axis=0) * (1 + 1e-9) + 1e-150).all()


@given(samples, limits)
@settings(deadline=None)
def test_order_does_not_matter(signals: np.ndarray, s_max: float) -> None:
    backwards = signals[::-1]
    for method in (cumulative, power):
        assert (
            saturated(method(backwards), s_max)
            == pytest.approx(saturated(method(signals), s_max), rel=1e-9, abs=1e-6)
            or method is power
        )
    assert np.abs(saturated(strongest(backwards), s_max)) == pytest.approx(
        np.abs(saturated(strongest(signals), s_max))
    )


def test_saturated_keeps_what_fits() -> None:
    assert saturated(np.array([-3.0, -1.0, 0.25, 1.0, 9.0]), 1.0).tolist() == [
        -1.0,
        -1.0,
        0.25,
        1.0,
        1.0,
    ]


def test_wearing_off_is_exponential() -> None:
    voice = Voice("fire", Constant(0.8) * Decay(2.0), np.ones(1))
    renderer = Renderer([ListenerMix("hand")])
    block = np.concatenate(
        [renderer.render_frame(n / 25, (n + 1) / 25, [voice]) for n in range(100)], axis=1
    )[0]
    assert np.abs(block - 0.8 * np.exp(-np.arange(len(block)) / 8000 / 2.0)).max() < 1e-12


VOICES = [Voice(name, Sine(frequency), np.array([gain]), priority=priority) for name, frequency, gain, priority in (
    ("a", 50.0, 0.9, 0.5), ("b", 83.0, 0.7, 1.0), ("c", 111.0, 0.4, 2.0))]  # fmt: skip


@pytest.mark.parametrize("method", ["cumulative", "weighted", "strongest", "power"])
def test_renderer_mixes_by_the_listeners_method(method: str) -> None:
    renderer = Renderer([ListenerMix("hand", method, s_max=0.8)])  # type: ignore[arg-type]
    block = renderer.render_frame(0.0, 0.5, VOICES)[0]
    each = np.array(
        [
            voice.gains[0] * np.sin(2 * np.pi * voice.signal.frequency * np.arange(4000) / 8000)
            for voice in VOICES
        ]
    )  # type: ignore[attr-defined]
    mix = {
        "cumulative": each.sum(axis=0),
        "weighted": 0.5 * each[0] + each[1] + 2.0 * each[2],
        "strongest": np.take_along_axis(each, np.abs(each).argmax(axis=0)[None], axis=0)[0],
        "power": np.sqrt((each**2).sum(axis=0)) * np.where(each.sum(axis=0) < 0, -1, 1),
    }[method]
    different = np.abs(block - np.clip(mix, -0.8, 0.8)) > 1e-9
    # Where the sum crosses zero, its sign is a matter of rounding.
    assert not different[np.abs(each.sum(axis=0)) > 1e-9].any()


def test_custom_method() -> None:
    seen = []

    def loudest_two(signals: np.ndarray, weights: np.ndarray) -> np.ndarray:
        seen.append(weights.tolist())
        return np.sort(signals, axis=0)[-2:].sum(axis=0)

    block = Renderer([ListenerMix("hand", loudest_two, s_max=10.0)]).render_frame(0.0, 0.1, VOICES)[
        0
    ]
    each = np.array([voice.gains[0] * voice.signal.sample(0, 800, 8000.0) for voice in VOICES])
    assert np.abs(block - np.sort(each, axis=0)[-2:].sum(axis=0)).max() < 1e-12
    assert seen == [[0.5, 1.0, 2.0]]


def test_a_custom_method_is_not_asked_about_silence() -> None:
    assert (
        not Renderer([ListenerMix("hand", lambda signals, _: signals.max(axis=0))])
        .render_frame(0.0, 0.1, [])
        .any()
    )


@pytest.mark.parametrize(
    "bad",
    [lambda signals, _: signals, lambda signals, _: signals.sum(axis=0) * np.nan, lambda *_: "no"],
)
def test_a_custom_method_that_fails_changes_nothing(bad: object) -> None:
    renderer = Renderer([ListenerMix("hand", bad)])  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"method|string"):
        renderer.render_frame(0.0, 0.1, VOICES)
    with pytest.raises(ValueError, match="unknown mixing method"):
        mixed("loudest", np.zeros((1, 1)), np.ones(1))  # type: ignore[arg-type]


@given(samples, limits, st.data())
@settings(deadline=None, derandomize=True)
def test_a_designers_formula_sees_what_the_other_methods_give(
    signals: np.ndarray, s_max: float, data: st.DataObject
) -> None:
    weights = data.draw(arrays(np.float64, len(signals), elements=st.floats(0, 10)))
    values = [
        cumulative(signals),
        weighted(signals, weights),
        strongest(signals),
        power(signals),
        np.full(signals.shape[1], s_max),
    ]
    for name, value in zip(MIXING_VARIABLES, values, strict=True):
        assert MixingExpression(name, s_max)(signals, weights).tolist() == value.tolist()
    total, squares = signals.sum(axis=0), (signals**2).sum(axis=0)
    soft = MixingExpression("s_max * tanh(sum / s_max)", s_max)(signals, weights)
    assert soft == pytest.approx(s_max * np.tanh(total / s_max), rel=1e-12, abs=1e-300)
    halves = MixingExpression("0.5 * strongest + 0.5 * where(sum < 0, -1, 1) * abs(power)")(
        signals, weights
    )
    expected = 0.5 * strongest(signals) + 0.5 * np.where(total < 0, -1, 1) * np.sqrt(squares)
    assert halves == pytest.approx(expected, rel=1e-9, abs=1e-100)


def test_a_formula_without_a_finite_value_is_silence() -> None:
    signals = np.array([[-1.0, 0.0, 4.0]])
    assert MixingExpression("sqrt(sum)")(signals, np.ones(1)).tolist() == [0.0, 0.0, 2.0]
    assert MixingExpression("1 / sum")(signals, np.ones(1)).tolist() == [-1.0, 0.0, 0.25]


def test_renderer_mixes_by_a_formula() -> None:
    listeners = [
        ListenerMix("hand", MixingExpression("tanh(sum)"), s_max=0.5),
        ListenerMix("foot", "cumulative", s_max=10.0),
    ]
    voices = [Voice(v.key, v.signal, np.repeat(v.gains, 2)) for v in VOICES]
    hand, foot = Renderer(listeners).render_frame(0.0, 0.5, voices)
    assert np.abs(hand - np.clip(np.tanh(foot), -0.5, 0.5)).max() < 1e-12


@pytest.mark.parametrize(
    ("formula", "words"),
    [
        ("sum", None),
        ("s_max * tanh(sum / s_max)", None),
        ("0.3 * power ** 2", None),
        ("sum + loud", "unknown name 'loud'; known are sum, weighted, strongest, power, s_max"),
        ("x * d", "unknown name 'x'"),
        ("__import__('os')", "can't be called"),
        ("sum +", "not a formula"),
        ("", "not a formula"),
        ("log(sum)", "no finite value where sum is"),
        ("sum + 0.25", "0.25 where no source sounds"),
    ],
)
def test_formulas_are_checked_while_they_are_written(formula: str, words: str | None) -> None:
    finding = check_mixing(formula)
    assert (finding is None) == (words is None)
    if finding is not None and words is not None:
        assert words in sentence(finding.message)
        if not finding.usable:
            with pytest.raises(ValueError, match="expression: "):
                MixingExpression(formula)


def test_a_listener_with_a_wrong_formula_is_refused() -> None:
    (mix,) = listener_mixes(
        [Listener("hand", "box", mixing="custom", mixing_expression="sum", s_max=0.5, radius=0.0)]
    )
    assert mix.method == MixingExpression("sum", 0.5)
    for formula in ("", "sum +", "loud"):
        with pytest.raises(ValueError, match=r"^mixing_expression: "):
            Listener("hand", "box", mixing="custom", mixing_expression=formula, radius=0.0)
    form = {
        "format": "haptic-scene",
        "version": "1.1",
        "objects": [{"name": "box", "kappa": 0, "rho": 1}],
    }
    form["listeners"] = [
        {
            "name": "hand",
            "object": "box",
            "position": [0, 0, 0],
            "mixing": "custom",
            "mixing_expression": "sum +",
        }
    ]
    with pytest.raises(FormatError, match="/listeners/0/mixing_expression: not a formula"):
        scene_from_dict(form, "scene.json")


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"s_max": 0.0}, "s_max"),
        ({"s_max": float("nan")}, "s_max"),
        ({"method": "loudest"}, "method"),
    ],
)
def test_bad_listeners_are_named(arguments: dict[str, object], name: str) -> None:
    with pytest.raises(ValueError, match=f"^{name}: "):
        ListenerMix("hand", **arguments)  # type: ignore[arg-type]
