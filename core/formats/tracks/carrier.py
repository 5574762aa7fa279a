"""A vibration as keyframes: one oscillation whose amplitude and frequency go in straight lines from key to key."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray


def _triangle(cycles: FloatArray) -> FloatArray:
    return np.asarray(1 - 4 * np.abs((cycles + 0.25) % 1.0 - 0.5))


WAVES: dict[str, Callable[[FloatArray], FloatArray]] = {
    "sine": lambda cycles: np.sin(2 * math.pi * (cycles - np.floor(cycles))),
    "square": lambda cycles: np.where(cycles - np.floor(cycles) < 0.5, 1.0, -1.0),
    "triangle": _triangle,
    "saw": lambda cycles: 2 * ((cycles + 0.5) % 1.0) - 1,
}
"""Waves of period 1 that begin at 0 and rise."""


@dataclass(frozen=True, slots=True, eq=False)
class Carrier:
    """``a(t) sin(phase + 2π ∫ f dt)``, or another wave of that phase, from ``start`` to ``end`` (seconds), silent elsewhere.

    phase: radians at the start. amplitude_times, amplitudes (n,) and frequency_times, frequencies (m,): keys, n and m >= 1, times in
    seconds from the start and never decreasing; the values hold before the first key and after the last. wave: a key of `WAVES`.
    """

    start: float
    end: float
    phase: float
    amplitude_times: FloatArray
    amplitudes: FloatArray
    frequency_times: FloatArray
    frequencies: FloatArray
    wave: str = "sine"

    def at(self, times: FloatArray) -> FloatArray:
        """The values at ``times`` (seconds, n), 0 outside [start, end)."""
        local = times - self.start
        amplitude = np.interp(local, self.amplitude_times, self.amplitudes)
        cycles = ramp_integral(local, self.frequency_times, self.frequencies)
        sounding = (times >= self.start) & (times < self.end)
        return np.where(sounding, amplitude * WAVES[self.wave](cycles + self.phase / (2 * math.pi)), 0.0)


def ramp_integral(times: FloatArray, key_times: FloatArray, values: FloatArray) -> FloatArray:
    """Integral from 0 of the straight lines through the keys, at ``times`` >= 0."""
    widths = np.diff(key_times)
    steps = np.concatenate([[0.0], np.cumsum(widths * (values[1:] + values[:-1]) / 2)])
    slopes = np.append(np.divide(np.diff(values), widths, out=np.zeros_like(widths), where=widths > 0), 0.0)
    index = np.maximum(np.searchsorted(key_times, times, side="right") - 1, 0)
    since = times - key_times[index]
    inside = np.maximum(since, 0.0)
    # Before the first key its value holds, so that the integral from 0 begins with that rectangle.
    return np.asarray(steps[index] + since * values[index] + slopes[index] * inside * inside / 2 + key_times[0] * values[0])


def rendered(carriers: Iterable[Carrier], count: int, sample_rate: float) -> FloatArray:
    """The sum of the carriers as ``count`` samples from time 0."""
    samples = np.zeros(count)
    for carrier in carriers:
        first = max(math.ceil(carrier.start * sample_rate), 0)
        last = min(math.ceil(carrier.end * sample_rate), count)
        if first < last:
            samples[first:last] += carrier.at(np.arange(first, last) / sample_rate)
    return samples
