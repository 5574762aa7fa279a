"""Vibrotactile perception: the threshold of feeling by frequency, the sensation level of a signal,
difference thresholds and masking.

The threshold is the closed form that haptic codecs use, a (log(c f + b) / log(b))^2 - e with a =
50, c = 1/550, b = 1 - 250 c and e = 45 (the reference software of ISO/IEC 23090-31): deepest at 250
Hz, rising to either side. What full scale is depends on the device. Without a calibration the
threshold at 250 Hz is assumed to lie 45 dB below it. Of a calibrated device (`FullScale`) the curve
is that of the skin's displacement, with `BEST_DISPLACEMENT` at 250 Hz: below 250 Hz it falls by 12
to 14 dB per octave, as measured thresholds of displacement do (R. T. Verrillo 1963: 12 dB).

Difference thresholds of amplitude are typical ones, of the middle of a group of people, and depend
on frequency and level. A. Israr, H. Z. Tan and C. M. Reed, J. Acoust. Soc. Am. 120 (2006) 2789, doi
10.1121/1.2354022: at the fingerpad, from 2 to 300 Hz, 1.82 to 2.98 dB at 20 dB above the threshold
and 1.65 to 2.71 dB at 35 dB; with one or two maskers 3.63 and 3.72 dB in the mean; masked
frequencies are distinguishable from a ratio of 1.46 (35 dB) to 1.60 (20 dB) on. N. G. Forta, M. J.
Griffin and M. Morioka 2012: thenar and forearm, medians of 12 people from 1.58 dB (125 Hz) to 3.97
dB (10 Hz). Just above the threshold of feeling they are far larger: 20 dB in the mean of 29 people
(C. Hatzfeld and R. Werthschuetzky 2012, doi 10.1007/978-3-642-31404-9_8).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .arrays import FloatArray, IntArray

BEST_FREQUENCY = 250.0
"""Frequency of the lowest threshold [Hz]."""
BEST_LEVEL = -45.0
"""The threshold at that frequency that is assumed without a calibration [dB of full scale]."""
BEST_DISPLACEMENT = 10 ** (-10 / 20) * 1e-6
"""The threshold at that frequency with a calibration: amplitude of the skin [m]. Small contactors
near 200 Hz need 0 to -10 dB re 1 um (M. Hamer), of which the lower end is chosen; every doubling of
the area lowers it by 3 dB."""
_STIFFNESS, _DAMPING, _MASS = 1000.0, 1.5, 1.5e-4
"""Of the skin under an actuator [N/m, N s/m, kg]: a fingertip (M. Wiertlewski and V. Hayward, J.
Biomech. 45, 2012)."""
CHANNELS_MEET = 40.0
"""Frequency [Hz] from which on the Pacinian channel feels more than the others."""
DIFFERENCE_THRESHOLDS = ((1.65, 3.97), (1.58, 2.98))
"""The lowest and the highest published typical difference threshold of amplitude [dB], below
`CHANNELS_MEET` and from there on."""
PEOPLE = 1.5
"""Assumed spread over people: the Weber fractions of two thirds of them lie within this factor of
the typical one (log-normal). No source that could be read gives it."""
MOST, FEW = 0.75, 0.25
"""Shares of people of whom it is said that they notice a difference, or don't."""
MASKED_DIFFERENCE_THRESHOLD = 3.72
"""Difference threshold of amplitude with maskers [dB]."""

MASKED_RATIO = 1.60
"""Ratio from which two frequencies are distinguishable even with maskers."""

_DEPTH = 50.0
_SLOPE = 1 / 550
_BASE = 1 - BEST_FREQUENCY * _SLOPE
_LOWEST, _HIGHEST = 5.0, 1000.0


def noticing(decibels: float, hertz: float) -> tuple[float, float]:
    """The share of people who notice a difference of ``decibels`` between two levels of a frequency
    that lie 10 dB or more above the threshold of feeling: if the typical threshold is the highest
    published one at that frequency, and if it is the lowest."""
    low, high = (
        _normal(math.log(_weber(abs(decibels)) / _weber(typical)) / math.log(PEOPLE))
        if decibels
        else 0.0
        for typical in reversed(DIFFERENCE_THRESHOLDS[hertz >= CHANNELS_MEET])
    )
    return low, high


def _weber(decibels: float) -> float:
    """The relative difference of amplitude of ``decibels``."""
    return math.expm1(min(decibels, 1000.0) * math.log(10) / 20)


def _normal(deviations: float) -> float:
    return 0.5 * math.erfc(-deviations / math.sqrt(2))


def are_felt_alike(decibels: float, hertz: float) -> bool:
    """Whether at most `FEW` notice a difference of ``decibels``, whichever study is right."""
    return noticing(decibels, hertz)[1] <= FEW


def are_felt_different(decibels: float, hertz: float) -> bool:
    """Whether at least `MOST` notice a difference of ``decibels``, whichever study is right."""
    return noticing(decibels, hertz)[0] >= MOST


class FullScale(NamedTuple):
    """The calibration of a device: what it does to the skin while it plays a sine of amplitude 1.

    ``points``: pairs of a frequency [Hz], rising, and the amplitude there, of the acceleration
    [m/s^2] or, if ``is_force``, of the force [N].
    """

    points: tuple[tuple[float, float], ...]
    is_force: bool = False

    def acceleration(self, frequency: NDArray[np.floating] | float) -> FloatArray:
        """Amplitude of the skin [m/s^2] at ``frequency`` (> 0) hertz: between the points along
        straight lines in doubly logarithmic scale, outside as at the nearest point. A force moves
        the skin as a mass on a spring with a damper."""
        hertz = np.asarray(frequency, dtype=np.float64)
        points = np.log(self.points)
        value = np.exp(np.interp(np.log(hertz), points[:, 0], points[:, 1]))
        if not self.is_force:
            return value
        angular = 2 * math.pi * hertz
        stiffness = np.hypot(_STIFFNESS - _MASS * angular**2, _DAMPING * angular)
        return value * angular**2 / stiffness


def threshold_level(
    frequency: NDArray[np.floating] | float, full_scale: FullScale | None = None
) -> FloatArray:
    """Threshold of feeling [dB of full scale] of a sine of ``frequency`` hertz (>= 0, of a
    calibrated device > 0)."""
    hertz = np.asarray(frequency, dtype=np.float64)
    bend = np.log10(_SLOPE * hertz + _BASE) / math.log10(_BASE)
    if full_scale is None:
        return _DEPTH * bend**2 + BEST_LEVEL
    best = BEST_DISPLACEMENT * (2 * math.pi * hertz) ** 2
    return np.asarray(_DEPTH * bend**2 + 20 * np.log10(best / full_scale.acceleration(hertz)))


@lru_cache(maxsize=256)
def lowest_threshold(full_scale: FullScale | None = None) -> float:
    """The lowest threshold of feeling at any tactile frequency [dB of full scale]."""
    return float(threshold_level(np.arange(_LOWEST, _HIGHEST + 1), full_scale).min())


def _felt_energy(
    samples: FloatArray, sample_rate: float, devices: Sequence[FullScale | None]
) -> tuple[FloatArray, FloatArray]:
    """Energies (..., f) of ``samples`` (..., n) at the tactile frequencies (f,) [Hz], relative to
    the threshold of ``devices``: one for each row or for all.

    A Hann window limits the leakage of a tone to frequencies of lower threshold.
    """
    count = samples.shape[-1]
    window, scale, felt, heard = _hearing(count, sample_rate)
    power = np.abs(np.fft.rfft(samples * window, axis=-1)[..., felt]) ** 2 * scale
    weights = {device: _weight(count, sample_rate, device) for device in set(devices)}
    if len(weights) > 1:
        return power * np.array([weights[device] for device in devices]), heard
    return power * weights[devices[0]], heard


@lru_cache(maxsize=16)
def _hearing(count: int, sample_rate: float) -> tuple[FloatArray, float, slice, FloatArray]:
    """The Hann window of ``count`` samples, the factor from its squared spectrum to energies, which
    of the frequencies are tactile, and these [Hz]."""
    window = np.hanning(count + 2)[1:-1]
    scale = 4 / (count * float((window**2).sum()))
    frequency = np.fft.rfftfreq(count, 1 / sample_rate)
    felt = slice(
        int(frequency.searchsorted(_LOWEST)), int(frequency.searchsorted(_HIGHEST, side="right"))
    )
    return window, scale, felt, np.asarray(frequency[felt], dtype=np.float64)


@lru_cache(maxsize=64)
def _weight(count: int, sample_rate: float, device: FullScale | None) -> FloatArray:
    """The factor on energies at the tactile frequencies that makes those of thresholds 1."""
    heard = _hearing(count, sample_rate)[3]
    return 10 ** (-threshold_level(heard, device) / 10)


def masked_by(
    samples: FloatArray, sample_rate: float, device: FullScale | None = None
) -> tuple[FloatArray, IntArray]:
    """For simultaneous signals (s, n) on one device: the sensation level (s,) of each alone [dB],
    and the number (s,) of the signal that masks it, -1 for none.

    A signal is masked if it raises the sensation level within `MASKED_RATIO` of its dominant
    frequency by no more than `MASKED_DIFFERENCE_THRESHOLD`, and if the level of the others there is
    above the threshold. Its masker is the strongest of them.
    """
    masker = np.full(len(samples), -1, dtype=np.int64)
    if samples.shape[-1] < 2 or not len(samples):
        return np.full(len(samples), -np.inf), masker
    energy, frequency = _felt_energy(samples, sample_rate, [device])
    with np.errstate(divide="ignore"):
        margin = 10 * np.log10(energy.sum(axis=1))
    for number in np.flatnonzero(margin > 0).tolist():
        own = frequency[np.argmax(energy[number])]
        near = energy[:, (frequency >= own / MASKED_RATIO) & (frequency <= own * MASKED_RATIO)].sum(
            axis=1
        )
        alone = float(near[number])
        near[number] = 0.0
        rest = float(near.sum())
        if rest > 1 and 10 * math.log10(1 + alone / rest) <= MASKED_DIFFERENCE_THRESHOLD:
            masker[number] = int(np.argmax(near))
    return margin, masker


def sensation_level(
    samples: FloatArray, sample_rate: float, devices: Sequence[FullScale | None] = (None,)
) -> FloatArray:
    """Sensation level (...) of ``samples`` (..., n): decibels above the threshold of feeling, minus
    infinity for silence. ``devices``: one for each row, or for all.

    The energies of all frequencies from 5 to 1000 Hz add up, each weighted by its threshold; that
    of a sine is its level minus `threshold_level`.
    """
    if samples.shape[-1] < 2:
        return np.full(samples.shape[:-1], -np.inf)
    with np.errstate(divide="ignore"):
        return np.asarray(
            10 * np.log10(_felt_energy(samples, sample_rate, devices)[0].sum(axis=-1))
        )


def dominant_frequency(
    samples: FloatArray, sample_rate: float, device: FullScale | None = None
) -> float:
    """The frequency in hertz that is felt most of ``samples`` (n,), 0 for silence."""
    if len(samples) < 2 or not np.any(samples):
        return 0.0
    energy, frequency = _felt_energy(samples, sample_rate, [device])
    return float(frequency[np.argmax(energy)]) if len(frequency) else 0.0
