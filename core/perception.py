"""What skin feels of a vibration: the threshold of feeling over frequency, how far a signal lies above it, and which differences it feels.

The threshold is the closed form that haptic codecs use, a (log(c f + b) / log(b))^2 - e with a = 50, c = 1/550, b = 1 - 250 c and e = 45
(the reference software of ISO/IEC 23090-31): deepest at 250 Hz, rising to either side. Its level depends on the device; here a sine of
250 Hz is just felt 45 dB below full scale.

Difference thresholds of amplitude are those of A. Israr, H. Z. Tan and C. M. Reed, "Frequency and amplitude discrimination along the
kinesthetic-cutaneous continuum in the presence of masking stimuli", J. Acoust. Soc. Am. 120 (2006) 2789, doi 10.1121/1.2354022: at the
fingerpad, from 2 to 300 Hz, 1.82 to 2.98 dB at 20 dB above the threshold and 1.65 to 2.71 dB at 35 dB; with one or two maskers 3.63 and
3.72 dB in the mean. There, too: two frequencies are told apart from a ratio of 1.46 (35 dB) to 1.60 (20 dB) on where others mask them.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .arrays import FloatArray, IntArray

BEST_FREQUENCY = 250.0
"""Hertz at which the least is felt."""
BEST_LEVEL = -45.0
"""Decibels of full scale that are just felt there."""
DIFFERENCE_THRESHOLDS = (1.65, 2.98)
"""Lowest and highest difference threshold of amplitude in decibels, whatever the frequency and the level."""
MASKED_DIFFERENCE_THRESHOLD = 3.72
"""The same where other vibration masks the difference."""

MASKED_RATIO = 1.60
"""Ratio of frequencies from which they are told apart, whatever masks them."""

_DEPTH = 50.0
_SLOPE = 1 / 550
_BASE = 1 - BEST_FREQUENCY * _SLOPE
_LOWEST, _HIGHEST = 5.0, 1000.0


def are_felt_alike(decibels: float) -> bool:
    """Whether nobody feels a difference of so many decibels between two levels of one frequency."""
    return abs(decibels) < DIFFERENCE_THRESHOLDS[0]


def are_felt_different(decibels: float, masked: bool = False) -> bool:
    """Whether everybody feels a difference of so many decibels, ``masked`` by other vibration or alone."""
    return abs(decibels) > (MASKED_DIFFERENCE_THRESHOLD if masked else DIFFERENCE_THRESHOLDS[1])


def threshold_level(frequency: NDArray[np.floating] | float) -> FloatArray:
    """Decibels of full scale at which a sine of ``frequency`` hertz (>= 0) is just felt; full scale is the amplitude 1."""
    bend = np.log10(_SLOPE * np.asarray(frequency, dtype=np.float64) + _BASE) / math.log10(_BASE)
    return np.asarray(_DEPTH * bend**2 + BEST_LEVEL)


def _felt_energy(samples: FloatArray, sample_rate: float) -> tuple[FloatArray, FloatArray]:
    """Energies (..., f) of ``samples`` (..., n) at the frequencies [Hz] that skin feels (f,), 1 where a sine is just felt.

    A Hann window keeps a tone from spilling over to where the threshold is lower.
    """
    count = samples.shape[-1]
    window = np.hanning(count + 2)[1:-1]
    frequency = np.fft.rfftfreq(count, 1 / sample_rate)
    felt = (frequency >= _LOWEST) & (frequency <= _HIGHEST)
    heard = np.asarray(frequency[felt], dtype=np.float64)
    power = np.abs(np.fft.rfft(samples * window, axis=-1)[..., felt]) ** 2 * (4 / (count * (window**2).sum()))
    return power * 10 ** (-threshold_level(heard) / 10), heard


def hidden_by(samples: FloatArray, sample_rate: float) -> tuple[FloatArray, IntArray]:
    """Of signals (s, n) that arrive together: decibels (s,) that each lies above the threshold of feeling alone, and the number (s,) of the
    one that hides it, -1 where none does.

    A signal is hidden where it raises what is felt within `MASKED_RATIO` of its own most felt frequency by no more than
    `MASKED_DIFFERENCE_THRESHOLD`, and what is felt there without it lies above the threshold. What hides it is the strongest of that.
    """
    masker = np.full(len(samples), -1, dtype=np.int64)
    if samples.shape[-1] < 2 or not len(samples):
        return np.full(len(samples), -np.inf), masker
    energy, frequency = _felt_energy(samples, sample_rate)
    with np.errstate(divide="ignore"):
        margin = 10 * np.log10(energy.sum(axis=1))
    for number in np.flatnonzero(margin > 0).tolist():
        own = frequency[np.argmax(energy[number])]
        near = energy[:, (frequency >= own / MASKED_RATIO) & (frequency <= own * MASKED_RATIO)].sum(axis=1)
        alone, near[number] = float(near[number]), 0.0
        rest = float(near.sum())
        if rest > 1 and not are_felt_different(10 * math.log10(1 + alone / rest), masked=True):
            masker[number] = int(np.argmax(near))
    return margin, masker


def sensation_level(samples: FloatArray, sample_rate: float) -> FloatArray:
    """Decibels that ``samples`` (..., n) lie above the threshold of feeling, (...); minus infinity for silence.

    The energies of all frequencies from 5 to 1000 Hz add up, each weighed by its threshold; a sine comes out at its level minus
    `threshold_level`.
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
