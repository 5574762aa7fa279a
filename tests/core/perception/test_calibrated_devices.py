"""Margins of calibrated devices against closed forms, and force against SciPy's response of a mass
on a damped spring."""

import math

import numpy as np
import pytest
from haptic_tracing.core.perception import (
    BEST_DISPLACEMENT,
    BEST_FREQUENCY,
    FullScale,
    masked_by,
    sensation_level,
    threshold_level,
)
from haptic_tracing.core.render.levels import level_and_margin
from haptic_tracing.core.scene.values import Listener
from scipy import signal

RATE = 8000


def test_the_threshold_is_the_displacement_that_the_device_makes_of_full_scale():
    device = FullScale(((40.0, 3.2), (160.0, 12.8)))
    # 12.8 m/s^2 at 160 Hz and beyond; halfway in octaves the geometric mean.
    assert device.acceleration(80.0) == pytest.approx(6.4)
    assert device.acceleration([10.0, 500.0]).tolist() == pytest.approx([3.2, 12.8])
    displacement = 12.8 / (2 * math.pi * BEST_FREQUENCY) ** 2
    at_best = 20 * math.log10(BEST_DISPLACEMENT / displacement)
    assert float(threshold_level(BEST_FREQUENCY, device)) == pytest.approx(at_best)
    # The shape of the curve is that of displacement.
    above = float(threshold_level(80.0) - threshold_level(BEST_FREQUENCY))
    made = 6.4 / (2 * math.pi * 80.0) ** 2
    assert float(threshold_level(80.0, device)) == pytest.approx(
        above + 20 * math.log10(BEST_DISPLACEMENT / made)
    )


def test_a_force_moves_a_fingertip_as_a_mass_on_a_damped_spring():
    hertz = np.geomspace(10, 800, 30)
    skin = signal.TransferFunction([1, 0, 0], [1.5e-4, 1.5, 1000.0])
    _, response = skin.freqresp(2 * math.pi * hertz)
    device = FullScale(((100.0, 0.2),), is_force=True)
    assert device.acceleration(hertz) == pytest.approx(0.2 * np.abs(response))


def test_margins_use_the_device_of_each_listener():
    weak = Listener("weak", "a", full_scale=((100.0, 1.0),), radius=0.0)
    strong = Listener("strong", "a", full_scale=((100.0, 10.0),), radius=0.0)
    pushing = Listener("pushing", "a", full_scale=((100.0, 1.0),), full_scale_unit="N", radius=0.0)
    listeners = (weak, strong, Listener("unknown", "a", radius=0.0), pushing)
    sine = 0.5 * np.sin(2 * math.pi * 100 * np.arange(RATE) / RATE)
    level, margin = level_and_margin(np.tile(sine, (4, 1)), RATE, listeners)
    assert level == pytest.approx(20 * math.log10(0.5 / math.sqrt(2)))
    expected = [-20 * math.log10(2) - float(threshold_level(100.0, x.device)) for x in listeners]
    assert margin == pytest.approx(expected, abs=0.1)
    assert margin[1] - margin[0] == pytest.approx(20)
    assert sensation_level(sine, RATE, [weak.device]) == pytest.approx(margin[0])
    alone, _ = masked_by(sine[None], RATE, strong.device)
    assert alone == pytest.approx(margin[1])


@pytest.mark.parametrize(
    ("points", "reason"),
    [
        (((40, 1), (40, 2)), "full_scale: expected up to 100 points by rising frequency"),
        (((40, 0),), "full_scale: numbers must be above 0 and at most 1e\\+06"),
        (((40, math.nan),), "full_scale: numbers must be above 0"),
    ],
)
def test_a_calibration_has_rising_frequencies_and_numbers_above_0(points, reason):
    with pytest.raises(ValueError, match=reason):
        Listener("a", "b", full_scale=points, radius=0.0)
