"""Envelopes, impacts and compositions against their formulas."""

from __future__ import annotations

import math

import numpy as np
import pytest
from haptic_tracing.core.signals import (
    Adsr,
    Automation,
    Constant,
    Decay,
    DecayingSine,
    Delay,
    Gain,
    Impulse,
    Keyed,
    Loop,
    Product,
    Sampled,
    Sequence,
    Signal,
    Sine,
    Sum,
    ramp,
)

RATE = 8000.0


def test_adsr() -> None:
    envelope = Adsr(attack=0.1, decay=0.2, sustain=0.4, release=0.3, hold=0.25)
    times = np.arange(8000) / RATE
    expected = np.interp(times, (0.0, 0.1, 0.3, 0.55, 0.85), (0.0, 1.0, 0.4, 0.4, 0.0))
    assert envelope.duration == pytest.approx(0.85)
    assert np.abs(envelope.sample(0, 8000, RATE) - expected).max() < 1e-12


def test_adsr_without_hold_never_releases() -> None:
    envelope = Adsr(attack=0.1, decay=0.2, sustain=0.4)
    assert envelope.duration == math.inf
    assert envelope.sample(8_000_000, 3, RATE).tolist() == pytest.approx([0.4, 0.4, 0.4])


def test_adsr_without_attack_begins_at_full() -> None:
    assert Adsr(attack=0.0, decay=0.1, sustain=0.0, release=0.0, hold=0.0).sample(
        0, 2, RATE
    ) == pytest.approx([1.0, 1 - 1 / 800])


def test_keyed() -> None:
    automation = Automation((0.0, 0.2, 0.2, 0.5), (0.0, 1.0, -0.5, 0.25))
    samples = Keyed(automation).sample(0, 8000, RATE)
    times = np.arange(8000) / RATE
    first = np.interp(times, (0.0, 0.2), (0.0, 1.0))
    second = np.interp(times, (0.2, 0.5), (-0.5, 0.25))
    expected = np.where(times < 0.2, first, np.where(times < 0.5, second, 0.0))
    assert np.abs(samples - expected).max() < 1e-12


def test_decay_and_decaying_sine() -> None:
    times = np.arange(8000) / RATE
    expected = np.exp(-times / 0.05)
    assert np.abs(Decay(0.05).sample(0, 8000, RATE) - expected).max() < 1e-4
    within = times < Decay(0.05).duration
    assert np.abs(Decay(0.05).sample(0, 8000, RATE) - expected)[within].max() < 1e-15
    ringing = 0.7 * expected * np.sin(2 * np.pi * 150 * times)
    assert (
        np.abs(DecayingSine(150.0, 0.05, 0.7).sample(0, 8000, RATE) - ringing)[within].max() < 1e-12
    )
    assert not DecayingSine(150.0, 0.05).sample(0, 8000, RATE)[~within].any()


def test_impulse_is_a_half_sine() -> None:
    samples = Impulse(0.01, 2.0).sample(0, 100, RATE)
    assert np.abs(samples[:80] - 2 * np.sin(np.pi * np.arange(80) / 80)).max() < 1e-12
    assert not samples[80:].any()
    assert samples.sum() / RATE == pytest.approx(2 * 2 * 0.01 / np.pi, rel=1e-3)


def test_operators_make_compositions() -> None:
    a, b = Sine(50.0), Constant(0.5, 0.1)
    assert a * b == Product((a, b))
    assert a + b == Sum((a, b))
    assert b >> a == Sequence((b, a))
    assert a * 2 == 2 * a == Gain(a, 2.0)
    assert a * ramp(0, 1, 1) == Gain(a, ramp(0, 1, 1))
    with pytest.raises(TypeError):
        a + 1.0  # type: ignore[operator]


def test_compositions_by_arithmetic_of_their_parts() -> None:
    a, b = Sine(50.0) * Constant(1.0, 0.3), Sine(80.0, 0.5) * Adsr(hold=0.1)
    left, right = a.sample(0, 4000, RATE), b.sample(0, 4000, RATE)
    assert np.array_equal((a + b).sample(0, 4000, RATE), left + right)
    assert np.array_equal((a * b).sample(0, 4000, RATE), left * right)
    assert np.array_equal((a * 0.25).sample(0, 4000, RATE), 0.25 * left)
    assert (a + b).duration == 0.3
    assert (a * b).duration == pytest.approx(0.26)


def test_delay_and_sequence_join_at_any_time() -> None:
    tone = Sine(50.0) * Constant(1.0, 0.10007)
    both = tone >> Sine(80.0)
    times = np.arange(4000) / RATE
    expected = np.where(
        times < 0.10007, np.sin(2 * np.pi * 50 * times), np.sin(2 * np.pi * 80 * (times - 0.10007))
    )
    assert np.abs(both.sample(0, 4000, RATE) - expected).max() < 1e-12
    later = Delay(Sine(80.0), 0.10007).sample(0, 4000, RATE)
    assert np.abs(later - np.where(times < 0.10007, 0.0, expected)).max() < 1e-12


def test_sequence_leaves_no_hole_between_parts() -> None:
    gates = Sequence(tuple(Constant(1.0, 0.1) for _ in range(50)))
    assert (gates.sample(0, 40_000 - 1, RATE) == 1.0).all()
    assert (Loop(Constant(1.0, 0.1)).sample(0, 400_000, RATE) == 1.0).all()


def test_loop_repeats() -> None:
    blow = DecayingSine(100.0, 0.01)
    once = blow.sample(0, 8000, RATE)
    looped = Loop(blow, count=3).sample(0, 8000, RATE)
    period = blow.duration
    expected = sum(blow.sample(0, 8000, RATE, onset=period * number) for number in range(3))
    assert np.abs(looped - expected).max() < 1e-9
    assert Loop(blow, 3).duration == pytest.approx(3 * period)
    assert once.any()


def test_loop_crossfade_has_no_step() -> None:
    cut = Sine(50.0) * Constant(1.0, 0.107)
    smooth, hard = (
        Loop(cut, crossfade=crossfade).sample(0, 16_000, RATE) for crossfade in (0.02, 0.0)
    )
    steepest = 2 * np.pi * 50 / RATE
    assert np.abs(np.diff(hard)).max() > 0.5
    assert np.abs(np.diff(smooth)).max() < 2 * steepest
    assert Loop(cut, 4, 0.02).duration == pytest.approx(4 * 0.087 + 0.02)
    last = Loop(cut, 4, 0.02).sample(0, 4000, RATE)
    pure = np.sin(2 * np.pi * 50 * (np.arange(4000) / RATE - 3 * 0.087))
    final = slice(math.ceil((3 * 0.087 + 0.02) * RATE), math.floor((3 * 0.087 + 0.107) * RATE))
    assert np.abs(last - pure)[final].max() < 1e-9


def test_sampled_returns_its_samples() -> None:
    numbers = np.random.default_rng(5).uniform(-1, 1, 500)
    assert np.array_equal(Sampled(numbers).sample(0, 600, RATE), np.append(numbers, np.zeros(100)))
    assert np.array_equal(Sampled(numbers).sample(90, 600, RATE, onset=100 / RATE)[10:510], numbers)


def test_sampled_between_samples() -> None:
    tone = np.sin(2 * np.pi * 200 * np.arange(4000) / RATE)
    onset = 0.333 / RATE
    samples = Sampled(tone).sample(0, 4000, RATE, onset)
    expected = np.sin(2 * np.pi * 200 * (np.arange(4000) / RATE - onset))
    assert np.abs(samples - expected)[50:-50].max() < 2e-5


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: Adsr(attack=-1.0), "attack"),
        (lambda: Adsr(sustain=1.5), "sustain"),
        (lambda: Adsr(attack=0, decay=0, release=0, hold=0), "attack"),
        (lambda: Constant(1.0, 0.0), "duration"),
        (lambda: Decay(0.0), "time_constant"),
        (lambda: DecayingSine(decay=float("nan")), "decay"),
        (lambda: Impulse(1e-9), "width"),
        (lambda: Keyed(Automation((-1.0, 0.0), (0.0, 1.0))), "track"),
        (lambda: Keyed(3.0), "track"),  # type: ignore[arg-type]
        (lambda: Automation((), ()), "times"),
        (lambda: Automation((0.0, 1.0), (1.0,)), "values"),
        (lambda: Automation((1.0, 0.0), (1.0, 1.0)), "times"),
        (lambda: Automation((0.0,), (float("nan"),)), "values"),
        (lambda: Automation("ab", (1.0, 2.0)), "times"),  # type: ignore[arg-type]
        (lambda: Sequence((Sine(), Sine())), "of"),
        (lambda: Sequence(()), "of"),
        (lambda: Sum((1.0,)), "of"),  # type: ignore[arg-type]
        (lambda: Loop(Sine()), "of"),
        (lambda: Loop(Impulse(), 0), "count"),
        (lambda: Loop(Impulse(), crossfade=1.0), "crossfade"),
        (lambda: Product((Sine(amplitude=1e5), Sine(amplitude=1e5))), "of"),
        (lambda: Sum((Sine(amplitude=1e6), Sine(amplitude=1e6))), "of"),
        (lambda: Gain(Sine(amplitude=1e5), 1e5), "gain"),
        (lambda: Delay(Sine(), -1.0), "seconds"),
        (lambda: Sampled([]), "samples"),  # type: ignore[arg-type]
        (lambda: Sampled([float("inf")]), "samples"),  # type: ignore[arg-type]
        (lambda: Sampled([1.0], 0.0), "rate"),  # type: ignore[arg-type]
        (lambda: Sine().sample(0, -1, RATE), "count"),
        (lambda: Sine().sample(0, 1, 0.0), "sample_rate"),
        (lambda: Sine().sample(0, 1, float("nan")), "sample_rate"),
    ],
)
def test_bad_arguments_are_named(make: object, name: str) -> None:
    with pytest.raises(ValueError, match=f"^{name}: "):
        make()  # type: ignore[operator]


def test_signals_are_values() -> None:
    signal: Signal = Sine(ramp(1.0, 2.0, 3.0)) * Adsr() + Sampled(np.ones(3))
    twin: Signal = Sine(ramp(1.0, 2.0, 3.0)) * Adsr() + Sampled(np.ones(3))
    assert signal == twin
    assert hash(signal) == hash(twin)
    assert signal != Sine(ramp(1.0, 2.0, 3.1)) * Adsr() + Sampled(np.ones(3))
    with pytest.raises(AttributeError):
        signal.of = ()  # type: ignore[attr-defined,misc]
    with pytest.raises(ValueError, match="read-only"):
        Sampled(np.ones(3)).samples[0] = 2.0
