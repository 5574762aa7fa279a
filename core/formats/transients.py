"""Impacts as transients: short bursts that a player adds to the continuous vibration."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

TRANSIENT_SECONDS = 0.022
TRANSIENT_CYCLES = 2
"""Two sine cycles over 22 ms: what the reference renderer of MPEG haptics plays, and the length that all clips of Razer's kit give."""
LEAST_STRENGTH = 0.02
"""A weaker transient says nothing that the continuous vibration does not."""


def without_transients(samples: FloatArray, sample_rate: int, impacts: FloatArray, time_step: float) -> tuple[FloatArray, FloatArray]:
    """The samples (n,) less a transient per impact, and the transients (k, 2): times, multiples of ``time_step`` seconds, and strengths.

    A transient has the strength with which it takes most out of the samples, so that both together are what there was.
    """
    if not len(impacts):
        return samples, np.zeros((0, 2))
    length = math.ceil(TRANSIENT_SECONDS * sample_rate)
    times = np.unique(np.rint(impacts[:, 0] / time_step)) * time_step
    first = np.ceil(times * sample_rate - 1e-9).astype(np.int64)
    within = first + length <= len(samples)
    times, first = times[within], first[within]
    points = first[:, None] + np.arange(length)
    bursts = burst(points / sample_rate - times[:, None])
    strengths = np.sum(samples[points] * bursts, axis=1) / np.maximum(np.sum(bursts * bursts, axis=1), 1e-12)
    strengths = np.clip(np.round(strengths, 4), 0.0, 1.0)
    felt = strengths >= LEAST_STRENGTH
    rest = samples.copy()
    np.subtract.at(rest, points[felt], strengths[felt, None] * bursts[felt])
    return rest, np.column_stack([times[felt], strengths[felt]])


def burst(times: FloatArray) -> FloatArray:
    """A transient of strength 1 at ``times`` seconds after its beginning."""
    inside = (times >= 0) & (times < TRANSIENT_SECONDS)
    return np.where(inside, np.sin(2 * math.pi * TRANSIENT_CYCLES / TRANSIENT_SECONDS * times), 0.0)
