"""What holds for every signal that can be built: block independence, bounds, end, and the way
through JSON."""

from __future__ import annotations

import json
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
    Noise,
    Product,
    Pulse,
    Sampled,
    Saw,
    Sequence,
    Signal,
    Sine,
    Square,
    Struck,
    Sum,
    Triangle,
    signal_from_dict,
)
from haptic_tracing.core.signals.limits import MIN_SECONDS
from hypothesis import given, settings
from hypothesis import strategies as st


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False)


@st.composite
def automations(draw: st.DrawFn, low: float, high: float) -> Automation:
    times = sorted(draw(st.lists(numbers(-2.0, 3.0), min_size=1, max_size=5)))
    return Automation(times, [draw(numbers(low, high)) for _ in times])


def parameters(low: float, high: float) -> st.SearchStrategy[float | Automation]:
    return numbers(low, high) | automations(low, high)


frequencies = parameters(0.0, 20_000.0) | parameters(0.0, 400.0)
levels = parameters(-30.0, 30.0)
seconds = numbers(0.001, 2.0)
simple = st.one_of(
    st.builds(Sine, frequencies, levels, numbers(-5, 5)),
    st.builds(Square, frequencies, levels, numbers(-5, 5)),
    st.builds(Triangle, frequencies, levels),
    st.builds(Saw, frequencies, levels),
    st.builds(Pulse, frequencies, levels, duty=numbers(0, 1)),
    st.builds(Noise, levels, st.integers(0, 2**64 - 1), numbers(1.0, 48_000.0)),
    st.builds(Constant, numbers(-30, 30), seconds | st.just(math.inf)),
    st.builds(Adsr, seconds, seconds, numbers(0, 1), seconds, seconds | st.just(math.inf)),
    st.builds(
        lambda end, values: Keyed(Automation(np.linspace(0, end, len(values)), values)),
        seconds,
        st.lists(numbers(-9, 9), min_size=2),
    ),
    st.builds(Decay, seconds),
    st.builds(Impulse, seconds, numbers(-30, 30)),
    st.builds(DecayingSine, numbers(0, 20_000), numbers(0.001, 0.3), numbers(-30, 30)),
    st.builds(Sampled, st.lists(numbers(-1, 1), min_size=1, max_size=40), numbers(50.0, 48_000.0)),
)


def finite(signal: Signal) -> Signal:
    return signal if signal.duration < 100.0 else Product((signal, Constant(1.0, 0.3)))


def brief(signal: Signal) -> Signal:
    return signal if signal.duration < 10.0 else Product((signal, Constant(1.0, 0.3)))


def composed(inner: st.SearchStrategy[Signal]) -> st.SearchStrategy[Signal]:
    return st.one_of(
        st.builds(Gain, inner, parameters(-1.0, 1.0)),
        st.builds(Delay, inner, seconds),
        st.builds(lambda a, b: Product((Gain(a, 1e-3), Gain(b, 1e-3))), inner, inner),
        st.builds(lambda a, b: Sum((a, b)), inner, inner),
        st.builds(lambda a, b: Sequence((finite(a), b)), inner, inner),
        st.builds(
            lambda a, p, d, b: Struck(Gain(brief(a), 1e-3), p, d, b),
            inner,
            numbers(0.25, 4),
            numbers(0.01, 1),
            numbers(0, 1),
        ),
        st.builds(
            lambda a, n, c: Loop(a, n, c * a.duration),
            inner.map(finite).filter(lambda a: a.duration >= MIN_SECONDS),
            st.none() | st.integers(1, 5),
            numbers(0, 0.5),
        ),
    )


signals = st.recursive(simple, composed, max_leaves=6)
rates = st.sampled_from([8000.0, 1000.0, 44_100.0, 333.3])


@pytest.mark.slow
@given(
    signals,
    rates,
    numbers(-1.0, 1.0),
    st.integers(-500, 9000),
    st.lists(st.integers(0, 700), min_size=1, max_size=6),
)
@settings(deadline=None, max_examples=300)
def test_samples_do_not_depend_on_blocks(
    signal: Signal, rate: float, onset: float, start: int, sizes: list[int]
) -> None:
    whole = signal.sample(start, sum(sizes), rate, onset)
    begins = start + np.cumsum([0, *sizes[:-1]])
    blocks = [
        signal.sample(int(begin), size, rate, onset)
        for begin, size in zip(begins, sizes, strict=True)
    ]
    assert np.abs(np.concatenate(blocks) - whole).max(initial=0.0) <= 1e-12 * max(signal.peak, 1.0)


@pytest.mark.slow
@given(signals, rates, numbers(-1.0, 1.0))
@settings(deadline=None, max_examples=300)
def test_samples_are_finite_within_the_peak_and_zero_outside(
    signal: Signal, rate: float, onset: float
) -> None:
    samples = signal.sample(-1000, 9000, rate, onset)
    times = np.arange(-1000, 8000) / rate - onset
    assert np.isfinite(samples).all()
    assert np.abs(samples).max() <= signal.peak * (1 + 1e-9)
    assert not samples[(times < 0) | (times >= signal.duration)].any()


@pytest.mark.slow
@given(signals)
@settings(deadline=None, max_examples=300)
def test_json_keeps_every_signal(signal: Signal) -> None:
    text = json.dumps(signal.to_dict(), allow_nan=False)
    again = signal_from_dict(json.loads(text))
    assert again == signal
    assert hash(again) == hash(signal)
    assert json.dumps(again.to_dict()) == text


@given(frequencies, st.integers(0, 10**9))
@settings(deadline=None)
def test_samples_are_finite_days_later(frequency: float | Automation, start: int) -> None:
    for cls in (Sine, Square, Triangle, Saw, Pulse):
        samples = cls(frequency).sample(start, 64, 8000.0)
        assert np.isfinite(samples).all()
        assert np.abs(samples).max() <= 1.0 + 2.0**-52  # the sine is rounded
