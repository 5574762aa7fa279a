"""Impacts as transients: short bursts that a player adds to the continuous vibration."""

from __future__ import annotations

import math

import numpy as np

from ...arrays import FloatArray

TRANSIENT_SECONDS = 0.022
TRANSIENT_CYCLES = 2
"""Two sine cycles over 22 ms: what the reference renderer of MPEG haptics plays, and the length that all clips of Razer's kit give."""
LEAST_STRENGTH = 0.01
"""A weaker impact says nothing that the continuous vibration does not."""
LEAST_SHARE = 0.3
"""Of an impact's strength that its transient has at least, however little it resembles it: to devices it is a click."""


def without_transients(samples: FloatArray, sample_rate: int, impacts: FloatArray, time_step: float) -> tuple[FloatArray, FloatArray]:
    """The samples (n,) less a transient per impact, and the transients (k, 2): times, multiples of ``time_step`` seconds, and strengths.

    A transient has the strength with which it takes most out of the samples, within limits; both together are what there was.
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
    """A transient of strength 1 at ``times`` seconds after its beginning."""
    inside = (times >= 0) & (times < TRANSIENT_SECONDS)
    return np.where(inside, np.sin(2 * math.pi * TRANSIENT_CYCLES / TRANSIENT_SECONDS * times), 0.0)
