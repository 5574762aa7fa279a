"""The limiter: never above, nothing below, smooth, and the same in any blocks."""

from __future__ import annotations

import numpy as np
import pytest
from haptic_tracing.core.render.limiter import HOLD, LOOK_AHEAD, RELEASE, Limiter
from haptic_tracing.core.render.renderer import ListenerMix, Renderer
from haptic_tracing.core.render.voices import Voice
from haptic_tracing.core.signals import DecayingSine, Sine
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

RATE = 8000.0


def limited(samples: np.ndarray, s_max: float = 1.0, cuts: tuple[int, ...] = ()) -> np.ndarray:
    """One channel through a limiter in blocks, its latency taken out."""
    limiter = Limiter(np.array([s_max]), RATE)
    whole = np.concatenate((samples, np.zeros(limiter.latency)))[None, :]
    return np.concatenate(
        [limiter.process(block) for block in np.split(whole, cuts, axis=1)], axis=1
    )[0, limiter.latency :]


@st.composite
def inputs(draw: st.DrawFn) -> np.ndarray:
    """Anything from silence to spikes of 10^30."""
    size = draw(st.integers(1, 3000))
    base = np.random.default_rng(draw(st.integers(0, 99))).normal(size=size) * draw(
        st.sampled_from([0.0, 0.1, 1.0, 50.0])
    )
    for place in draw(st.lists(st.integers(0, size - 1), max_size=6)):
        base[place] = draw(st.floats(-1e30, 1e30))
    return base


@pytest.mark.slow
@given(inputs(), st.floats(1e-6, 1e6), st.lists(st.integers(0, 3000), max_size=4).map(sorted))
@settings(deadline=None, max_examples=300)
def test_never_above_and_independent_of_blocks(
    samples: np.ndarray, s_max: float, cuts: list[int]
) -> None:
    result = limited(samples, s_max)
    assert np.isfinite(result).all()
    assert np.abs(result).max() <= s_max
    in_blocks = limited(samples, s_max, tuple(cuts))
    assert np.abs(in_blocks - result).max() <= 1e-9 * s_max
    assert (np.sign(result) * np.sign(samples) >= 0).all()


@given(arrays(np.float64, st.integers(1, 500), elements=st.floats(-1, 1)))
@settings(deadline=None)
def test_transparent_below_the_limit(samples: np.ndarray) -> None:
    assert np.array_equal(limited(samples), samples)


def test_a_steady_tone_is_turned_down_without_distortion() -> None:
    for frequency in (20.0, 60.0, 250.0):
        tone = 3.0 * np.sin(2 * np.pi * frequency * np.arange(16_000) / RATE)
        result = limited(tone)[8000:]
        spectrum = np.abs(np.fft.rfft(result * np.hanning(8000)))
        fundamental = int(frequency)
        rest = np.delete(spectrum, range(fundamental - 3, fundamental + 4))
        assert np.sqrt((rest**2).sum() / (spectrum**2).sum()) < 1e-3
        clipped = np.abs(np.fft.rfft(np.clip(tone[8000:], -1, 1) * np.hanning(8000)))
        assert (
            np.sqrt(
                (np.delete(clipped, range(fundamental - 3, fundamental + 4)) ** 2).sum()
                / (clipped**2).sum()
            )
            > 0.1
        )
        assert np.abs(result).max() == pytest.approx(1.0, abs=0.02)


def test_gain_changes_smoothly() -> None:
    """A soft carrier with one spike: its gain moves no faster than the look-ahead's window lets
    it."""
    carrier = np.full(8000, 0.5)
    carrier[4000] = 100.0
    gain = limited(carrier) / carrier
    assert gain[4000] == pytest.approx(0.01, rel=1e-6)
    steps = np.abs(np.diff(gain))
    assert steps.max() < 1.1 * 2 / (LOOK_AHEAD * RATE)
    assert (gain[: 4000 - int(LOOK_AHEAD * RATE) - 1] == 1.0).all()
    assert gain[4000 + int((HOLD - LOOK_AHEAD) * RATE)] == pytest.approx(0.01, rel=1e-6)
    assert gain[-1] == pytest.approx(
        0.01 * np.exp(((3999 - LOOK_AHEAD * RATE / 2) / RATE - HOLD) / RELEASE), rel=0.02
    )


def test_reset_forgets() -> None:
    limiter = Limiter(np.array([1.0]), RATE)
    limiter.process(np.full((1, 500), 50.0))
    limiter.reset()
    assert np.array_equal(
        limiter.process(np.full((1, 500), 0.5))[0, limiter.latency :],
        np.full(500 - limiter.latency, 0.5),
    )


def test_renderer_holds_s_max_and_keeps_listeners_together() -> None:
    """One listener with a limiter delays all alike; a bake takes the delay out."""
    listeners = [
        ListenerMix("hand", s_max=0.5, limiter=True),
        ListenerMix("foot", s_max=0.5),
        ListenerMix("ear", s_max=10.0),
    ]
    renderer = Renderer(listeners)
    assert renderer.latency == 40
    voices = [
        Voice("blow", DecayingSine(120.0, 0.05), np.ones(3), onset=0.1017),
        Voice("hum", Sine(60.0), np.full(3, 0.4), onset=0.0),
    ]
    blocks = [renderer.render_frame(number / 25, (number + 1) / 25, voices) for number in range(26)]
    samples = np.concatenate(blocks, axis=1)[:, renderer.latency : renderer.latency + 8000]
    assert samples.shape == (3, 8000)
    times = np.arange(8000) / RATE
    since = times - 0.1017
    sounding = (since >= 0) & (since < DecayingSine(120.0, 0.05).duration)
    total = sounding * np.exp(-since / 0.05) * np.sin(2 * np.pi * 120 * since) + 0.4 * np.sin(
        2 * np.pi * 60 * times
    )
    assert np.abs(samples[2] - total).max() < 1e-9
    assert np.abs(samples[1] - np.clip(total, -0.5, 0.5)).max() < 1e-9
    assert np.abs(samples[0]).max() <= 0.5
    assert np.abs(samples[0] - total)[:700].max() < 1e-9
