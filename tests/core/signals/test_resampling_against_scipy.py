"""Interpolation and resampling against tones and scipy.signal.resample_poly."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.signal
from haptic_tracing.core.signals.interpolation import interpolate, resample
from hypothesis import given, settings
from hypothesis import strategies as st


def rich(rate: float, seconds: float, highest: float) -> np.ndarray:
    """Many tones up to `highest` hertz, at rest at both ends."""
    random = np.random.default_rng(1)
    times = np.arange(int(rate * seconds)) / rate
    tones = sum(
        np.sin(2 * np.pi * f * times + p)
        for f, p in zip(random.uniform(20, highest, 40), random.uniform(0, 6, 40), strict=True)
    )
    return tones / 40 * np.sin(np.pi * times / seconds) ** 2


@pytest.mark.parametrize(
    ("rate", "new_rate"),
    [
        (48_000, 8000),
        (44_100, 8000),
        (22_050, 8000),
        (16_000, 8000),
        (11_025, 8000),
        (8000, 48_000),
        (8000, 44_100),
        (96_000, 8000),
    ],
)
def test_as_scipy_within_a_thousandth(rate: int, new_rate: int) -> None:
    samples = rich(rate, 1.0, 0.35 * min(rate, new_rate))
    divisor = np.gcd(rate, new_rate)
    expected = scipy.signal.resample_poly(
        samples, new_rate // divisor, rate // divisor, window=("kaiser", 12.0)
    )
    result = resample(samples, rate, new_rate)
    assert result.shape == expected.shape
    assert np.abs(result - expected).max() < 1e-3 * np.abs(expected).max()


@pytest.mark.parametrize("rate", [48_000, 44_100, 22_050, 11_025, 8000, 6000, 4001.5])
def test_tones_that_skin_feels(rate: float) -> None:
    times = np.arange(int(2 * rate)) / rate
    new_times = np.arange(16_000) / 8000
    for frequency in (20.0, 60.0, 250.0, 1000.0):
        result = resample(np.sin(2 * np.pi * frequency * times), rate, 8000)[: len(new_times)]
        error = np.abs(result - np.sin(2 * np.pi * frequency * new_times[: len(result)]))
        assert error[200:-200].max() < 3e-5


def test_what_the_new_rate_cannot_carry_is_gone() -> None:
    times = np.arange(48_000) / 48_000
    for frequency in (4900.0, 6000.0, 7900.0, 8100.0, 15_950.0):
        assert (
            np.abs(resample(np.sin(2 * np.pi * frequency * times), 48_000, 8000)[200:-200]).max()
            < 1e-4
        )


def test_same_rate_is_the_same_samples() -> None:
    samples = rich(8000, 0.1, 3000)
    assert np.array_equal(resample(samples, 8000.0, 8000.0), samples)


@given(st.floats(0.05, 0.4), st.lists(st.floats(40, 160), min_size=1, max_size=30))
@settings(deadline=None)
def test_interpolation_of_a_tone_is_within_a_ten_thousandth(
    cycles_per_sample: float, positions: list[float]
) -> None:
    tone = np.sin(2 * np.pi * cycles_per_sample * np.arange(200))
    result = interpolate(tone[None, :], np.array(positions))[0]
    assert np.abs(result - np.sin(2 * np.pi * cycles_per_sample * np.array(positions))).max() < 1e-4


@given(
    st.floats(1.0, 9.0),
    st.lists(st.floats(-1e9, 1e9) | st.floats(-60, 260), max_size=30),
    st.integers(0, 30),
)
@settings(deadline=None)
def test_each_position_is_looked_up_alone(stretch: float, positions: list[float], cut: int) -> None:
    samples = np.random.default_rng(2).uniform(-1, 1, (2, 200))
    together = interpolate(samples, np.array(positions), stretch)
    apart = [
        interpolate(samples, np.array(piece), stretch)
        for piece in (positions[:cut], positions[cut:])
    ]
    assert np.abs(together - np.concatenate(apart, axis=1)).max(initial=0.0) < 1e-12


def test_regular_positions_are_looked_up_as_irregular_ones() -> None:
    samples = np.random.default_rng(3).uniform(-1, 1, (2, 200))
    positions = np.arange(150) + 20.37
    shuffled = np.random.default_rng(4).permutation(150)
    assert (
        np.abs(
            interpolate(samples, positions)[:, shuffled] - interpolate(samples, positions[shuffled])
        ).max()
        < 1e-12
    )


def test_silence_beyond_the_ends() -> None:
    samples = np.ones((1, 50))
    assert not interpolate(samples, np.array([-1e12, -17.0, 66.0, 1e12])).any()
    assert np.array_equal(interpolate(samples, np.arange(50.0)), samples)
