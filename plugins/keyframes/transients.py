"""Impacts as transients: short bursts that players add to the continuous vibration."""

from __future__ import annotations

import math

import numpy as np

from ...core.arrays import FloatArray, IntArray
from ...core.formats.tracks.listener_tracks import Row
from .carrier import Carrier

TRANSIENT_SECONDS = 0.022
TRANSIENT_CYCLES = 2
"""Two sine cycles over 22 ms, as the reference renderer of MPEG haptics plays; published `.haps`
clips have the same length."""
LEAST_STRENGTH = 0.01
"""Minimum strength; weaker impacts stay in the continuous vibration."""
LEAST_SHARE = 0.3
"""Minimum strength of a transient relative to its impact's, however similar they are, because
devices render it as a click."""


def without_transients(row: Row, impacts: FloatArray, time_step: float) -> tuple[Row, FloatArray]:
    """The samples minus one transient per impact, and the transients (k, 2): time, a multiple of
    ``time_step`` seconds, and strength.

    The strength is the least-squares fit to the samples, within limits. Samples and transients add
    up to the input.
    """
    if not len(impacts):
        return row, np.zeros((0, 2))
    length = math.ceil(TRANSIENT_SECONDS * row.sample_rate)
    ticks, number = np.unique(np.rint(impacts[:, 0] / time_step), return_inverse=True)
    times = ticks * time_step
    felt = np.zeros(len(times))
    np.maximum.at(felt, number, impacts[:, 1])
    first = np.ceil(times * row.sample_rate - 1e-9).astype(np.int64)
    within = (first + length <= row.count) & (felt >= LEAST_STRENGTH)
    times = times[within]
    first = first[within]
    felt = felt[within]
    bursts = burst((first[:, None] + np.arange(length)) / row.sample_rate - times[:, None])
    shares = np.array(
        [
            np.dot(row.read(start, start + length), wave)
            for start, wave in zip(first.tolist(), bursts, strict=True)
        ]
    )
    strengths = shares / np.maximum(np.sum(bursts * bursts, axis=1), 1e-12)
    strengths = np.round(np.clip(strengths, LEAST_SHARE * felt, felt), 4)
    return _Remainder(row, first, strengths[:, None] * bursts), np.column_stack([times, strengths])


class _Remainder(Row):
    """A row minus ``bursts`` (k, m), which begin at the indices ``first`` (k,), ascending."""

    def __init__(self, row: Row, first: IntArray, bursts: FloatArray) -> None:
        self._row, self._first, self._bursts = row, first, bursts
        self.count, self.sample_rate = row.count, row.sample_rate

    def read(self, first: int, last: int) -> FloatArray:
        samples = self._row.read(first, last)
        length = self._bursts.shape[1]
        low, high = np.searchsorted(self._first, [first - length, last])
        if low == high:
            return samples
        padded = np.concatenate([np.zeros(length), samples, np.zeros(length)])
        for begin, values in zip(
            (self._first[low:high] - first + length).tolist(), self._bursts[low:high], strict=True
        ):
            padded[begin : begin + length] -= values
        return padded[length : length + len(samples)]


def burst(times: FloatArray) -> FloatArray:
    """A transient of strength 1 at ``times`` seconds after its start."""
    inside = (times >= 0) & (times < TRANSIENT_SECONDS)
    return np.where(inside, np.sin(2 * math.pi * TRANSIENT_CYCLES / TRANSIENT_SECONDS * times), 0.0)


def transient_carrier(time: float, strength: float) -> Carrier:
    """A transient at ``time`` seconds as an oscillation."""
    zero = np.zeros(1)
    frequency = np.full(1, TRANSIENT_CYCLES / TRANSIENT_SECONDS)
    return Carrier(time, time + TRANSIENT_SECONDS, 0.0, zero, np.full(1, strength), zero, frequency)
