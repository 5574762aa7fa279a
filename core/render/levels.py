"""Level and margin at a listener, from samples."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray
from ..perception import sensation_level
from ..scene.values import Listener

LEVEL_SECONDS = 0.25
"""Duration over which a level is computed [s]."""
_ROUNDING = 1e-12


def vibration_rms(samples: FloatArray, sample_rate: float) -> FloatArray:
    """The root mean square (...) of ``samples`` (..., n) without their steady part, a push that
    nobody feels.

    That is the bin at 0 Hz of the spectrum of at least `LEVEL_SECONDS`: a high-pass at 2 Hz or
    below. Fewer samples count as followed by silence, so that a short blow does not lose its own
    mean.
    """
    count = samples.shape[-1]
    energy = np.square(samples, dtype=np.float64).sum(axis=-1)
    steady = np.square(samples.sum(axis=-1, dtype=np.float64)) / max(
        count, LEVEL_SECONDS * sample_rate
    )
    rest = np.where(energy - steady > _ROUNDING * energy, energy - steady, 0.0)
    return np.asarray(np.sqrt(rest / max(count, 1)))


def margins(samples: FloatArray, sample_rate: float, listeners: Sequence[Listener]) -> FloatArray:
    """The margins (l,) [dB] of ``samples`` (l, n) above the thresholds of feeling, by the devices
    of ``listeners``, () for those assumed; minus infinity for silence."""
    devices = [item.device for item in listeners] or [None] * len(samples)
    sounding = np.asarray(samples.any(axis=1)).nonzero()[0]
    if 0 < len(sounding) == len(samples):
        return sensation_level(samples, sample_rate, devices)
    found = np.full(len(samples), -np.inf)
    if len(sounding):
        theirs = [devices[row] for row in sounding.tolist()]
        found[sounding] = sensation_level(samples[sounding], sample_rate, theirs)
    return found


def level_and_margin(
    samples: FloatArray, sample_rate: float, listeners: Sequence[Listener] = ()
) -> tuple[FloatArray, FloatArray]:
    """Of each row of ``samples`` (l, n): the RMS level (l,) without the steady part [dB of full
    scale], and its `margins`; minus infinity for silence."""
    with np.errstate(divide="ignore"):
        level = np.asarray(20 * np.log10(vibration_rms(samples, sample_rate)))
    return level, margins(samples, sample_rate, listeners)


def finite(decibels: float) -> float | None:
    """A level in decibels, None for silence."""
    return decibels if math.isfinite(decibels) else None
