"""The colour map: even, in order for every eye, and true to the scale in decibels."""

import math

import numpy as np
import pytest
from haptic_tracing.addon.view.colour_map import STEPS, AmplitudeScale, colour_table
from hypothesis import given
from hypothesis import strategies as st
from oklab import from_oklab, interpolated, oklab

# CSS Color Module Level 4, sample conversions of the primaries to Oklab.
PUBLISHED = {
    (1, 1, 1): (1.0, 0.0, 0.0),
    (1, 0, 0): (0.62796, 0.22486, 0.12585),
    (0, 1, 0): (0.86644, -0.23389, 0.17950),
    (0, 0, 1): (0.45201, -0.03246, -0.31153),
}

# Machado, Oliveira and Fernandes, "A physiologically-based model for simulation of color vision
# deficiency", 2009, severity 1.
COLOUR_BLINDNESS = {
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}


@pytest.mark.parametrize(("srgb", "lab"), PUBLISHED.items())
def test_oklab_against_published_values(srgb, lab):
    assert oklab(np.array(srgb, dtype=float)) == pytest.approx(lab, abs=2e-4)
    assert from_oklab(oklab(np.array(srgb, dtype=float))) == pytest.approx(srgb, abs=1e-6)


def test_the_table_is_the_line_through_the_control_points():
    assert colour_table() == pytest.approx(interpolated(STEPS), abs=1e-12)


def test_neighbours_differ_by_the_same():
    steps = np.linalg.norm(np.diff(oklab(colour_table()), axis=0), axis=1)
    assert steps.max() / steps.min() < 1.1


def test_lightness_always_rises():
    assert (np.diff(oklab(colour_table())[:, 0]) > 0).all()


@pytest.mark.parametrize("kind", COLOUR_BLINDNESS)
def test_order_is_seen_by_the_colour_blind(kind):
    seen = np.clip(colour_table() @ np.array(COLOUR_BLINDNESS[kind]).T, 0, 1)
    tenths = oklab(seen)[:: len(seen) // 10]
    assert (np.diff(tenths[:, 0]) > 0).all()
    # Oklab's just noticeable difference.
    assert np.linalg.norm(np.diff(tenths, axis=0), axis=1).min() > 0.02


@given(st.floats(0, 1))
def test_place_is_linear_in_decibels(gain):
    level = 20 * math.log10(gain) if gain else -math.inf
    place = AmplitudeScale().place(np.array(gain))
    assert place == pytest.approx(min(1, max(0, 1 + level / 60)), abs=1e-9)


@given(st.floats(-120, -10))
def test_ticks_are_few_round_and_on_the_scale(floor):
    scale = AmplitudeScale(floor)
    ticks = scale.ticks()
    assert ticks[-1] == 0
    assert 3 <= len(ticks) <= 7
    assert all(scale.floor <= tick <= 0 for tick in ticks)
    assert len(set(np.diff(ticks).tolist())) == 1


def test_gain_above_one_keeps_the_last_colour():
    scale = AmplitudeScale()
    assert np.array_equal(scale.colour(np.array([1.0, 7.0])), colour_table()[[-1, -1]])
