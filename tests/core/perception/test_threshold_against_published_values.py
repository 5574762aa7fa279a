"""The threshold of feeling against the published curve, sensation levels against closed forms."""

import math

import numpy as np
import pytest
from haptic_tracing.core.perception import (
    BEST_FREQUENCY,
    BEST_LEVEL,
    dominant_frequency,
    sensation_level,
    threshold_level,
)
from hypothesis import given, settings
from hypothesis import strategies as st

RATE = 8000.0

# Decibels above the threshold at 250 Hz, of the reference software of ISO/IEC 23090-31.
PUBLISHED = {
    20: 39.9,
    40: 31.5,
    60: 24.4,
    80: 18.6,
    100: 13.8,
    150: 5.5,
    200: 1.2,
    300: 1.0,
    400: 7.9,
    500: 19.1,
}


@pytest.mark.parametrize(("frequency", "above"), PUBLISHED.items())
def test_threshold_against_published_values(frequency, above):
    assert threshold_level(float(frequency)) - BEST_LEVEL == pytest.approx(above, abs=0.06)


def test_threshold_is_lowest_at_the_best_frequency_and_finite():
    frequency = np.arange(0.0, 4000.0)
    level = threshold_level(frequency)
    assert np.isfinite(level).all()
    assert frequency[level.argmin()] == BEST_FREQUENCY
    assert level.min() == BEST_LEVEL


@settings(derandomize=True, deadline=None)
@given(st.floats(20, 500), st.floats(1e-4, 1), st.floats(0, 6.28))
def test_sensation_level_of_a_sine_is_its_level_over_the_threshold(frequency, amplitude, phase):
    time = np.arange(4000) / RATE
    samples = amplitude * np.sin(2 * math.pi * frequency * time + phase)
    expected = 20 * math.log10(amplitude) - float(threshold_level(frequency))
    assert sensation_level(samples, RATE) == pytest.approx(expected, abs=0.25)
    assert dominant_frequency(samples, RATE) == pytest.approx(frequency, abs=3)


def test_energies_of_tones_add_up():
    time = np.arange(8000) / RATE
    tones = [
        10 ** (float(threshold_level(f)) / 20) * np.sin(2 * math.pi * f * time)
        for f in (60.0, 250.0)
    ]
    for tone in tones:
        assert sensation_level(tone, RATE) == pytest.approx(0, abs=0.05)
    assert sensation_level(sum(tones), RATE) == pytest.approx(10 * math.log10(2), abs=0.05)


def test_silence_and_what_skin_does_not_feel():
    assert sensation_level(np.zeros((3, 100)), RATE).tolist() == [-math.inf] * 3
    assert sensation_level(np.zeros((2, 0)), RATE).tolist() == [-math.inf] * 2
    assert dominant_frequency(np.zeros(100), RATE) == 0
    assert dominant_frequency(np.zeros(0), RATE) == 0
    too_high = np.sin(2 * math.pi * 3000 * np.arange(4000) / RATE)
    assert sensation_level(too_high, RATE) < 0
