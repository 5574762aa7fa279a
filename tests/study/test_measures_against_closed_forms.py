"""Measures of levels of which the answer is known."""

import numpy as np
import pytest
from haptic_tracing.study import measures

SIDES = ("hand.L", "hand.R")


def test_active_are_those_above_a_hundredth_of_full_scale():
    assert measures.active_count(
        np.array([[0.0, 0.01, 0.0101, 1.0], [0.0, 0.0, 0.0, 0.0]])
    ).tolist() == [2, 0]


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
    levels = 10 ** (np.linspace(-30, -10, 401).reshape(-1, 1) / 20)
    assert measures.dynamic_range(levels) == pytest.approx(18.0, abs=0.1)
    assert measures.dynamic_range(np.full((5, 2), 0.3)) == 0.0
    assert measures.dynamic_range(np.zeros((5, 2))) == 0.0


def test_variety_of_equally_frequent_intensities_is_the_logarithm_of_their_number():
    levels = 10 ** ((-1.0 - 3.0 * np.arange(8)) / 20)
    assert measures.variety(np.repeat(levels, 5).reshape(-1, 1)) == pytest.approx(3.0)
    assert measures.variety(np.full((4, 3), 0.5)) == 0.0
    assert measures.variety(np.zeros((4, 3))) == 0.0


def test_patterns_do_not_count_strength():
    alike = np.outer(np.linspace(0.2, 0.9, 6), [1.0, 0.5, 0.25])
    assert measures.patterns(alike) == 0.0
    assert measures.patterns(np.concatenate([alike, alike[:, ::-1]])) == pytest.approx(1.0)
    assert measures.patterns(np.zeros((3, 3))) == 0.0


def test_spectrogram_of_a_full_scale_sine_is_0_decibels_at_its_frequency():
    rate, count = 8000, 8192
    sine = np.sin(2 * np.pi * 250.0 * np.arange(count) / rate)
    seconds, hertz, power = measures.spectrogram(np.stack([sine, sine]), rate)
    assert power.shape == (len(hertz), len(seconds)) == (513, 15)
    assert hertz[power.argmax(axis=0)] == pytest.approx([250.0] * 15)
    assert power.max(axis=0) == pytest.approx([0.0] * 15, abs=1e-3)
    assert measures.spectrogram(np.zeros((2, 100)), rate)[2].shape == (513, 0)
