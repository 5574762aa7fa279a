"""Daily exposure of the skin to vibration, A(8), from calibrated tracks."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

import numpy as np
from scipy import signal

from ...core.arrays import FloatArray
from ...core.perception import FullScale

EIGHT_HOURS = 8 * 3600.0


HAND, BODY = (2.5, 5.0), (0.5, 1.15)
"""Daily exposure from which action is due, and the limit, of directive 2002/44/EC [m/s^2]."""


def limits_of(part: str) -> tuple[float, float]:
    """The limits at a body part: of hands and arms, or of the whole body."""
    arm = ("hand", "index_finger", "forearm", "upper_arm")
    return HAND if part.partition(".")[0] in arm else BODY


def hand_weighting(frequency: FloatArray) -> FloatArray:
    """W_h of ISO 5349-1:2001, annex A, at frequencies [Hz]."""
    return _weighting(frequency, (6.310, 1258.9), _transition(15.915, 0.64))


def body_weighting(frequency: FloatArray) -> FloatArray:
    """W_k of ISO 2631-1:1997, annex A, of vertical vibration of a seat, at frequencies [Hz]."""
    step = ([1, 2.37 / 0.91, 2.37**2], [1, 3.35 / 0.91, 3.35**2])
    return _weighting(frequency, (0.4, 100.0), _transition(12.5, 0.63), step)


def _transition(corner: float, quality: float) -> Any:
    """From acceleration to velocity: numerator and denominator, of Hz as all of these filters."""
    return [corner, corner**2], [1, corner / quality, corner**2]


def _weighting(frequency: FloatArray, band: tuple[float, float], *filters: Any) -> FloatArray:
    """The product of filters and of the two Butterworth filters of second order that limit it."""
    low, high = band
    limits = [signal.butter(2, low, "high", analog=True), signal.butter(2, high, analog=True)]
    gains = [np.abs(signal.freqs(*one, frequency)[1]) for one in (*limits, *filters)]
    return np.asarray(np.prod(gains, axis=0))


def daily(
    tracks: Collection[tuple[FloatArray, FullScale | None]],
    sample_rate: float,
    actuators: Collection[tuple[float, FullScale | None]],
    part: str,
) -> float | None:
    """A(8) [m/s^2] at a body part from all that is played there in a day; of several actuators the
    largest. None where neither a track nor its actuator is calibrated.

    Args:
        tracks: Samples (n,) of the listener, each with the calibration of the listener's device,
            which goes before that of the actuator.
        sample_rate: Samples per second.
        actuators: The gain and the calibration of each that plays the listener; without any the
            gain is 1.
        part: The body part.
    """
    weighting = hand_weighting if limits_of(part) is HAND else body_weighting
    largest = 0.0
    for gain, actuator in actuators or [(1.0, None)]:
        square = 0.0
        for samples, listener in tracks:
            device = listener or actuator
            if device is None:
                return None
            frequency = np.fft.rfftfreq(len(samples), 1 / sample_rate)[1:].astype(np.float64)
            spectrum = gain * np.fft.rfft(samples)[1:] * device.acceleration(frequency)
            power = np.abs(spectrum * weighting(frequency)) ** 2
            square += 2 * float(power.sum()) / (len(samples) * sample_rate)
        largest = max(largest, square)
    return math.sqrt(largest / EIGHT_HOURS)
