"""Measures of levels of which the answer is known."""

import numpy as np
import pytest
from haptic_tracing.core.perception import threshold_level
from haptic_tracing.core.signals import Sampled, Sine
from haptic_tracing.study import measures

SIDES = ("hand.L", "hand.R")


def test_felt_is_what_lies_above_the_threshold_of_feeling():
    assert measures.felt_count(
        np.array([[-np.inf, -0.1, 0.1, 20.0], [0.0, -3.0, -40.0, -np.inf]])
    ).tolist() == [2, 0]


def test_loudness_is_the_margin_of_a_signal_of_amplitude_1():
    margin, hertz = measures.loudness(Sine(120.0))
    assert margin == pytest.approx(-float(threshold_level(120.0)), abs=0.1)
    assert hertz == pytest.approx(120, abs=2)
    # A knock of 20 ms in the middle of a window of 250 ms is 8 dB weaker than the tone that lasts.
    knock = 20 * np.log10(np.sqrt(0.02 / 0.25 * 8 / 3))  # Hann: 8/3 at its middle
    found, _ = measures.loudness(Sampled(np.sin(2 * np.pi * 250 * np.arange(160) / 8000), 8000.0))
    assert found == pytest.approx(45 + knock, abs=1.0)


def test_spread_of_two_alike_is_half_their_distance_and_of_one_alone_nothing():
    positions = np.array([[0.0, 0.0, 0.0], [0.0, 3.0, 4.0]])
    levels = np.array([[0.2, 0.2], [0.7, 0.0], [0.0, 0.0], [0.1, 0.3]])
    # Weights p and 1 - p at a distance d: d sqrt(p (1 - p)).
    assert measures.spatial_spread(levels, positions) == pytest.approx(
        [2.5, 0.0, 0.0, 5 * np.sqrt(0.25 * 0.75)]
    )


def test_balance_goes_from_minus_one_at_the_left_to_one_at_the_right():
    levels = np.array([[0.5, 0.0], [0.0, 0.1], [0.2, 0.2], [0.0, 0.0], [0.3, 0.1]])
    assert measures.balance(levels, SIDES) == pytest.approx([-1.0, 1.0, 0.0, 0.0, -0.5])


def test_range_of_levels_that_go_up_evenly_in_decibels():
    margins = np.linspace(-20, 20, 801).reshape(-1, 1)
    assert measures.dynamic_range(margins) == pytest.approx(18.0, abs=0.1)
    assert measures.dynamic_range(np.full((5, 2), 3.0)) == 0.0
    assert measures.dynamic_range(np.full((5, 2), -3.0)) == 0.0


def test_variety_of_equally_frequent_intensities_is_the_logarithm_of_their_number():
    margins = 1.0 + 4.0 * np.arange(8)
    assert measures.variety(np.repeat(margins, 5).reshape(-1, 1)) == pytest.approx(3.0)
    assert measures.variety(np.full((4, 3), 5.0)) == 0.0
    assert measures.variety(np.full((4, 3), -5.0)) == 0.0


def test_patterns_do_not_count_strength():
    alike = np.linspace(20, 35, 6)[:, None] - [0.0, 6.0, 12.0]
    assert measures.patterns(alike) == 0.0
    assert measures.patterns(np.concatenate([alike, alike[:, ::-1]])) == pytest.approx(1.0)
    assert measures.patterns(np.full((3, 3), -1.0)) == 0.0


def test_the_mean_margin_is_that_of_the_mean_energy_felt():
    margins = np.array([[10.0, -5.0], [-np.inf, 10.0]])
    assert measures.mean_margin(margins) == pytest.approx(10 - 10 * np.log10(2))
    assert measures.mean_margin(np.full((2, 2), -1.0)) == -np.inf


def test_spectrogram_of_a_full_scale_sine_is_0_decibels_at_its_frequency():
    rate, count = 8000, 8192
    sine = np.sin(2 * np.pi * 250.0 * np.arange(count) / rate)
    seconds, hertz, power = measures.spectrogram(np.stack([sine, sine]), rate)
    assert power.shape == (len(hertz), len(seconds)) == (513, 15)
    assert hertz[power.argmax(axis=0)] == pytest.approx([250.0] * 15)
    assert power.max(axis=0) == pytest.approx([0.0] * 15, abs=1e-3)
    assert measures.spectrogram(np.zeros((2, 100)), rate)[2].shape == (513, 0)
