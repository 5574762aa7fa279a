"""Impacts as transients: short bursts that players add to the continuous vibration."""

from __future__ import annotations

import math

import numpy as np

from ...arrays import FloatArray

TRANSIENT_SECONDS = 0.022
TRANSIENT_CYCLES = 2
"""Two sine cycles over 22 ms, as the reference renderer of MPEG haptics plays; published `.haps` clips have the same length."""
LEAST_STRENGTH = 0.01
"""Minimum strength; weaker impacts stay in the continuous vibration."""
LEAST_SHARE = 0.3
"""Minimum strength of a transient relative to its impact's, whatever their similarity, since devices render it as a click."""


def without_transients(samples: FloatArray, sample_rate: int, impacts: FloatArray, time_step: float) -> tuple[FloatArray, FloatArray]:
    """The samples (n,) minus one transient per impact, and the transients (k, 2): time, a multiple of ``time_step`` seconds, and strength.

    The strength is the least-squares fit to the samples, within limits. Samples and transients add up to the input.
    """
    if not len(impacts):
        return samples, np.zeros((0, 2))
    length = math.ceil(TRANSIENT_SECONDS * sample_rate)
    ticks, number = np.unique(np.rint(impacts[:, 0] / time_step), return_inverse=True)
    times = ticks * time_step
    felt = np.zeros(len(times))
    np.maximum.at(felt, number, impacts[:, 1])
    first = np.ceil(times * sample_rate - 1e-9).astype(np.int64)
    within = first + length <= len(samples)
    within &= felt >= LEAST_STRENGTH
    times, first, felt = times[within], first[within], felt[within]
    points = first[:, None] + np.arange(length)
    bursts = burst(points / sample_rate - times[:, None])
    strengths = np.sum(samples[points] * bursts, axis=1) / np.maximum(np.sum(bursts * bursts, axis=1), 1e-12)
    strengths = np.round(np.clip(strengths, LEAST_SHARE * felt, felt), 4)
    rest = samples.copy()
    np.subtract.at(rest, points, strengths[:, None] * bursts)
    return rest, np.column_stack([times, strengths])


def burst(times: FloatArray) -> FloatArray:
    """A transient of strength 1 at ``times`` seconds after its start."""
    inside = (times >= 0) & (times < TRANSIENT_SECONDS)
    return np.where(inside, np.sin(2 * math.pi * TRANSIENT_CYCLES / TRANSIENT_SECONDS * times), 0.0)
