"""Measures of a rendering from the levels (f, l) of frames at listeners."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import FloatArray, IntArray
from ..core.perception import DIFFERENCE_THRESHOLDS, sensation_level, threshold_level
from ..core.scene.bands import BAND_COUNT, BAND_EDGES
from ..core.signals import Signal

ACTIVE = 0.01
"""Least drive of an active actuator, relative to full scale (-40 dB)."""
CLASS_WIDTH = DIFFERENCE_THRESHOLDS[1]
"""Decibels within which two levels count as the same intensity."""

WINDOW = 0.25
"""Integration time of the skin [s], as in the meters."""
LOWEST, HIGHEST = 5.0, 1000.0
"""Range of tactile frequencies [Hz]."""
_RATE = 8000.0


def active_count(peak: FloatArray) -> IntArray:
    """Number of active actuators in each frame (f,)."""
    return np.asarray((peak > ACTIVE).sum(axis=1), dtype=np.int64)


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


def dynamic_range(levels: FloatArray) -> float:
    """Decibels between the 95th and the 5th percentile of the effects' ``levels`` (e, l) at active
    actuators; 0 where none is active."""
    active = levels[levels > ACTIVE]
    if not len(active):
        return 0.0
    low, high = np.percentile(active, (5, 95))
    return float(20 * np.log10(high / low))


def variety(levels: FloatArray) -> float:
    """Entropy of the intensity of active actuators in bits: that of ``levels`` (e, l) in classes of
    `CLASS_WIDTH`."""
    active = levels[levels > ACTIVE]
    return _entropy(np.floor(20 * np.log10(active) / CLASS_WIDTH)) if len(active) else 0.0


def patterns(levels: FloatArray) -> float:
    """Entropy of the spatial patterns of effects, relative to their strongest actuator, in bits:
    that of rows of ``levels`` (e, l) in classes of `CLASS_WIDTH`; 0 if all effects differ only in
    strength."""
    felt = levels[(levels > ACTIVE).any(axis=1)]
    if not len(felt):
        return 0.0
    beside = np.where(felt > ACTIVE, felt / felt.max(axis=1, keepdims=True), ACTIVE)
    return _entropy(np.floor(20 * np.log10(beside) / CLASS_WIDTH + 0.5))


def _entropy(classes: FloatArray) -> float:
    """Bits per row."""
    _, counts = np.unique(classes, axis=0, return_counts=True)
    share = counts / counts.sum()
    return abs(float((share * np.log2(share)).sum()))


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
