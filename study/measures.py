"""Measures of a rendering from margins and levels at listeners. A margin is a level above the
threshold of feeling [dB]; what lies at or below 0 is not felt."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import FloatArray, IntArray
from ..core.perception import (
    DIFFERENCE_THRESHOLDS,
    dominant_frequency,
    sensation_level,
    threshold_level,
)
from ..core.scene.bands import BAND_COUNT, BAND_EDGES
from ..core.signals import Signal

CLASS_WIDTH = max(high for _, high in DIFFERENCE_THRESHOLDS)
"""Decibels within which two levels count as the same intensity."""

WINDOW = 0.25
"""Integration time of the skin [s], as in the meters."""
LOWEST, HIGHEST = 5.0, 1000.0
"""Range of tactile frequencies [Hz]."""
_RATE = 8000.0


def felt_count(margin: FloatArray) -> IntArray:
    """Number of actuators at which anything is felt, by frame (f,), of margins (f, l)."""
    return np.asarray((margin > 0).sum(axis=1), dtype=np.int64)


def spatial_spread(rms: FloatArray, positions: FloatArray) -> FloatArray:
    """Spatial spread of the vibration per frame (f,): root of the mean square distance in metres of
    the ``positions`` (l, 3) from their centre, weighted by level; 0 if at most one actuator is
    active."""
    total = rms.sum(axis=1)
    weight = rms / np.where(total > 0, total, 1.0)[:, None]
    centre = weight @ positions
    square = np.einsum("fl,l->f", weight, (positions**2).sum(axis=1)) - (centre**2).sum(axis=1)
    return np.where(total > 0, np.sqrt(np.maximum(square, 0.0)), 0.0)


def balance(rms: FloatArray, listeners: Sequence[str]) -> FloatArray:
    """Left-right balance per frame (f,): -1 if only listeners of the left feel something, 1 for the
    right, 0 if both are equal."""
    left = rms[:, [name.endswith(".L") for name in listeners]].sum(axis=1)
    right = rms[:, [name.endswith(".R") for name in listeners]].sum(axis=1)
    total = left + right
    return np.where(total > 0, (right - left) / np.where(total > 0, total, 1.0), 0.0)


def dynamic_range(margins: FloatArray) -> float:
    """Decibels between the 95th and the 5th percentile of the effects' ``margins`` (e, l) where
    they are felt; 0 where none is."""
    felt = margins[margins > 0]
    return float(np.subtract(*np.percentile(felt, (95, 5)))) if len(felt) else 0.0


def variety(margins: FloatArray) -> float:
    """Entropy of what is felt in bits: that of ``margins`` (e, l) in classes of `CLASS_WIDTH`."""
    felt = margins[margins > 0]
    return _entropy(np.floor(felt / CLASS_WIDTH)) if len(felt) else 0.0


def patterns(margins: FloatArray) -> float:
    """Entropy of the spatial patterns of effects, relative to their strongest actuator, in bits:
    that of rows of ``margins`` (e, l) in classes of `CLASS_WIDTH`; 0 if all effects differ only in
    strength. What isn't felt counts as if it were just at the threshold."""
    felt = np.maximum(margins[(margins > 0).any(axis=1)], 0.0)
    if not len(felt):
        return 0.0
    return _entropy(np.floor((felt - felt.max(axis=1, keepdims=True)) / CLASS_WIDTH + 0.5))


def mean_margin(margins: FloatArray) -> float:
    """The mean energy of what is felt over frames and actuators (f, l), as a margin [dB]; minus
    infinity if nothing is."""
    felt = np.where(margins > 0, margins, -np.inf)
    with np.errstate(divide="ignore"):
        return float(10 * np.log10((10 ** (felt / 10)).mean()))


def _entropy(classes: FloatArray) -> float:
    """Bits per row."""
    _, counts = np.unique(classes, axis=0, return_counts=True)
    share = counts / counts.sum()
    return abs(float((share * np.log2(share)).sum()))


@lru_cache(maxsize=256)
def loudness(signal: Signal) -> tuple[float, float]:
    """The margin [dB] of a signal of amplitude 1 in its first second, and the frequency [Hz] that
    is felt most of it."""
    samples = signal.sample(0, round(_RATE), _RATE)
    around = np.pad(samples, round(WINDOW * _RATE))  # windows fade what is at their ends
    return float(highest_sensation(around[None], _RATE)[0]), dominant_frequency(samples, _RATE)


@lru_cache(maxsize=256)
def felt_shares(signal: Signal) -> FloatArray:
    """The shares (6,) of the frequency bands in the felt energy of the first second of a signal."""
    samples = signal.sample(0, round(_RATE), _RATE)
    if math.isinf(signal.duration):
        samples = samples * np.hanning(len(samples))
    power = np.abs(np.fft.rfft(samples)) ** 2
    hertz = np.fft.rfftfreq(len(samples), 1 / _RATE)
    felt = (hertz >= LOWEST) & (hertz <= HIGHEST)
    energy = power[felt] * 10 ** (-threshold_level(hertz[felt]) / 10)
    shares = np.bincount(np.searchsorted(BAND_EDGES[1:-1], hertz[felt]), energy, BAND_COUNT)
    return np.asarray(shares / shares.sum())


def highest_sensation(samples: NDArray[np.floating], sample_rate: float) -> FloatArray:
    """The largest sensation level (l,) [dB] of each listener's ``samples`` (l, n) in windows of
    `WINDOW`."""
    width = round(WINDOW * sample_rate)
    ends = range(min(width, samples.shape[1]), samples.shape[1] + 1, max(width // 8, 1))
    found = [
        sensation_level(
            np.asarray(samples[:, max(end - width, 0) : end], dtype=np.float64), sample_rate
        )
        for end in ends
    ]
    return np.asarray(np.max(found, axis=0)) if samples.shape[1] else np.full(len(samples), -np.inf)


def spectrogram(
    samples: NDArray[np.floating], sample_rate: float, width: int = 1024
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Power of the listeners' ``samples`` (l, n) together, in decibels of a full-scale sine's:
    seconds (t,), hertz (h,), (h, t).

    Hann windows of ``width`` samples, half overlapping; floor at -100 dB.
    """
    hop = width // 2
    count = max((samples.shape[1] - width) // hop + 1, 0)
    window = np.hanning(width)
    frequencies = np.fft.rfftfreq(width, 1 / sample_rate)
    power = np.zeros((len(frequencies), count))
    for k in range(count):
        piece = np.asarray(samples[:, k * hop : k * hop + width], dtype=np.float64)
        power[:, k] = (np.abs(np.fft.rfft(piece * window)) ** 2).sum(axis=0)
    power /= len(samples) * (window.sum() / 2) ** 2
    seconds = (np.arange(count) * hop + width / 2) / sample_rate
    return (
        seconds,
        np.asarray(frequencies, dtype=np.float64),
        10 * np.log10(np.maximum(power, 1e-10)),
    )
