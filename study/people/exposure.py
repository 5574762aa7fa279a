"""Daily exposure of the skin to vibration, A(8), from calibrated tracks."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...core.arrays import FloatArray
from ...core.formats.tracks.vibration_file import Channel
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
    return _weighting(frequency, 6.310, 1258.9, 15.915, 0.64)


def body_weighting(frequency: FloatArray) -> FloatArray:
    """W_k of ISO 2631-1:1997, annex A, of vertical vibration of a seat, at frequencies [Hz]."""
    step = _resonator(frequency, 2.37, 0.91) / _resonator(frequency, 3.35, 0.91)
    gain = _weighting(frequency, 0.4, 100.0, 12.5, 0.63) * np.abs(step) * (2.37 / 3.35) ** 2
    return np.asarray(gain)


def _weighting(
    frequency: FloatArray, low: float, high: float, corner: float, quality: float
) -> FloatArray:
    """The gain from acceleration to velocity above a corner, in a band.

    Args:
        frequency: Where [Hz].
        low: Lower limit of the band, of a Butterworth filter of second order [Hz].
        high: Upper limit [Hz].
        corner: Where the gain begins to fall with frequency [Hz].
        quality: Of that transition.
    """
    band = _resonator(frequency, low) * _resonator(frequency, high)
    transition = _resonator(frequency, corner, quality) / (1 + 1j * frequency / corner)
    return np.asarray((frequency / low) ** 2 / np.abs(band * transition))


def _resonator(frequency: FloatArray, corner: float, quality: float = math.sqrt(0.5)) -> Any:
    """The denominator of a filter of second order."""
    angle = 1j * frequency / corner
    return 1 + angle / quality + angle**2


def daily(
    tracks: list[Channel], actuators: list[tuple[float, FullScale | None]], part: str
) -> float:
    """A(8) [m/s^2] at a body part from all that is played there in a day; of several actuators the
    largest. NaN where neither a track nor its actuator is calibrated.

    Args:
        tracks: Of the listener; the calibration of its device goes before that of the actuator.
        actuators: The gain and the calibration of each that plays the listener; without any the
            gain is 1.
        part: The body part.
    """
    weighting = hand_weighting if limits_of(part) is HAND else body_weighting
    squares = []
    for gain, actuator in actuators or [(1.0, None)]:
        squares.append(0.0)
        for track in tracks:
            device = track.device or actuator
            if device is None:
                return math.nan
            samples, rate = np.asarray(track.samples), track.sample_rate
            frequency = np.fft.rfftfreq(len(samples), 1 / rate)[1:].astype(np.float64)
            gains = gain * device.acceleration(frequency) * weighting(frequency)
            length = float(np.linalg.norm(gains * np.fft.rfft(samples)[1:]))
            squares[-1] += 2 * length**2 / (len(samples) * rate)
    return math.sqrt(max(squares) / EIGHT_HOURS)
