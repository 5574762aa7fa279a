"""Level and margin at a listener, from samples."""

from __future__ import annotations

import math

import numpy as np

from ..arrays import FloatArray
from ..perception import sensation_level

LEVEL_SECONDS = 0.25
"""Duration over which a level is computed [s]."""


def level_and_margin(samples: FloatArray, sample_rate: float) -> tuple[FloatArray, FloatArray]:
    """Of each row of ``samples`` (l, n): the RMS level (l,) [dB of full scale] and the margin (l,) [dB] above the threshold of feeling;
    minus infinity for silence."""
    rms = np.sqrt((samples**2).mean(axis=1)) if samples.shape[1] else np.zeros(len(samples))
    with np.errstate(divide="ignore"):
        return np.asarray(20 * np.log10(rms)), sensation_level(samples, sample_rate)


def finite(decibels: float) -> float | None:
    """A level in decibels, None for silence."""
    return decibels if math.isfinite(decibels) else None
