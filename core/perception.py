"""Vibrotactile perception: the threshold of feeling by frequency, the sensation level of a signal,
difference thresholds and masking.

The threshold is the closed form that haptic codecs use, a (log(c f + b) / log(b))^2 - e with a =
50, c = 1/550, b = 1 - 250 c and e = 45 (the reference software of ISO/IEC 23090-31): deepest at 250
Hz, rising to either side. The absolute level depends on the device; here the threshold at 250 Hz is
45 dB below full scale.

Difference thresholds of amplitude are those of A. Israr, H. Z. Tan and C. M. Reed, "Frequency and
amplitude discrimination along the kinesthetic-cutaneous continuum in the presence of masking
stimuli", J. Acoust. Soc. Am. 120 (2006) 2789, doi 10.1121/1.2354022: at the fingerpad, from 2 to
300 Hz, 1.82 to 2.98 dB at 20 dB above the threshold and 1.65 to 2.71 dB at 35 dB; with one or two
maskers 3.63 and 3.72 dB in the mean. Also from there: masked frequencies are distinguishable from a
ratio of 1.46 (35 dB) to 1.60 (20 dB) on.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .arrays import FloatArray, IntArray

BEST_FREQUENCY = 250.0
"""Frequency of the lowest threshold [Hz]."""
BEST_LEVEL = -45.0
"""The threshold at that frequency [dB of full scale]."""
DIFFERENCE_THRESHOLDS = (1.65, 2.98)
"""Lowest and highest difference threshold of amplitude over all frequencies and levels [dB]."""
MASKED_DIFFERENCE_THRESHOLD = 3.72
"""Difference threshold of amplitude with maskers [dB]."""

MASKED_RATIO = 1.60
"""Ratio from which two frequencies are distinguishable even with maskers."""

_DEPTH = 50.0
_SLOPE = 1 / 550
_BASE = 1 - BEST_FREQUENCY * _SLOPE
_LOWEST, _HIGHEST = 5.0, 1000.0


def are_felt_alike(decibels: float) -> bool:
    """Whether nobody feels a difference of ``decibels`` between two levels of one frequency."""
    return abs(decibels) < DIFFERENCE_THRESHOLDS[0]


def are_felt_different(decibels: float, masked: bool = False) -> bool:
    """Whether everybody feels a difference of ``decibels``, with or without maskers
    (``masked``)."""
    return abs(decibels) > (MASKED_DIFFERENCE_THRESHOLD if masked else DIFFERENCE_THRESHOLDS[1])


def threshold_level(frequency: NDArray[np.floating] | float) -> FloatArray:
    """Threshold of feeling [dB of full scale] of a sine of ``frequency`` hertz (>= 0); full scale
    is the amplitude 1."""
    bend = np.log10(_SLOPE * np.asarray(frequency, dtype=np.float64) + _BASE) / math.log10(_BASE)
    return np.asarray(_DEPTH * bend**2 + BEST_LEVEL)


def _felt_energy(samples: FloatArray, sample_rate: float) -> tuple[FloatArray, FloatArray]:
    """Energies (..., f) of ``samples`` (..., n) at the tactile frequencies (f,) [Hz], relative to
    the threshold.

    A Hann window limits the leakage of a tone to frequencies of lower threshold.
    """
    count = samples.shape[-1]
    window = np.hanning(count + 2)[1:-1]
    frequency = np.fft.rfftfreq(count, 1 / sample_rate)
    felt = (frequency >= _LOWEST) & (frequency <= _HIGHEST)
    heard = np.asarray(frequency[felt], dtype=np.float64)
    power = np.abs(np.fft.rfft(samples * window, axis=-1)[..., felt]) ** 2 * (
        4 / (count * (window**2).sum())
    )
    return power * 10 ** (-threshold_level(heard) / 10), heard


def masked_by(samples: FloatArray, sample_rate: float) -> tuple[FloatArray, IntArray]:
    """For simultaneous signals (s, n): the sensation level (s,) of each alone [dB], and the number
    (s,) of the signal that masks it, -1 for none.

    A signal is masked if it raises the sensation level within `MASKED_RATIO` of its dominant
    frequency by no more than `MASKED_DIFFERENCE_THRESHOLD`, and if the level of the others there is
    above the threshold. Its masker is the strongest of them.
    """
    masker = np.full(len(samples), -1, dtype=np.int64)
    if samples.shape[-1] < 2 or not len(samples):
        return np.full(len(samples), -np.inf), masker
    energy, frequency = _felt_energy(samples, sample_rate)
    with np.errstate(divide="ignore"):
        margin = 10 * np.log10(energy.sum(axis=1))
    for number in np.flatnonzero(margin > 0).tolist():
        own = frequency[np.argmax(energy[number])]
        near = energy[:, (frequency >= own / MASKED_RATIO) & (frequency <= own * MASKED_RATIO)].sum(
            axis=1
        )
        alone, near[number] = float(near[number]), 0.0
        rest = float(near.sum())
        if rest > 1 and not are_felt_different(10 * math.log10(1 + alone / rest), masked=True):
            masker[number] = int(np.argmax(near))
    return margin, masker


def sensation_level(samples: FloatArray, sample_rate: float) -> FloatArray:
    """Sensation level (...) of ``samples`` (..., n): decibels above the threshold of feeling, minus
    infinity for silence.

    The energies of all frequencies from 5 to 1000 Hz add up, each weighted by its threshold; that
    of a sine is its level minus `threshold_level`.
    """
    if samples.shape[-1] < 2:
        return np.full(samples.shape[:-1], -np.inf)
    with np.errstate(divide="ignore"):
        return np.asarray(10 * np.log10(_felt_energy(samples, sample_rate)[0].sum(axis=-1)))


def dominant_frequency(samples: FloatArray, sample_rate: float) -> float:
    """The frequency in hertz that is felt most of ``samples`` (n,), 0 for silence."""
    if len(samples) < 2 or not np.any(samples):
        return 0.0
    energy, frequency = _felt_energy(samples, sample_rate)
    return float(frequency[np.argmax(energy)]) if len(frequency) else 0.0
