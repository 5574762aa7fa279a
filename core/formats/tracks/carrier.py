"""A keyframed oscillation: amplitude and frequency are linear between keys."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import FloatArray
from ...signals import Automation, Delay, Keyed, Saw, Signal, Sine, Square, Triangle
from ...signals.oscillators import Oscillator

_OSCILLATORS: dict[str, tuple[Oscillator, float]] = {
    "sine": (Sine(), 0.0),
    "square": (Square(), 0.0),
    "triangle": (Triangle(), 0.0),
    "saw": (Saw(), 0.5),
}
"""Waves by name, with the cycles to add so that each begins at 0 (a square at its edge) and rises."""


@dataclass(frozen=True, slots=True, eq=False)
class Carrier:
    """``a(t) sin(phase + 2π ∫ f dt)``, or another wave of that phase, from ``start`` to ``end`` (seconds), silent elsewhere.

    phase: radians at the start. amplitude_times, amplitudes (n,) and frequency_times, frequencies (m,): keys, n and m >= 1, in seconds
    from the start, never decreasing, hertz; the values are constant before the first key and after the last. wave: sine, square, triangle
    or saw.
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
        oscillator, offset = _OSCILLATORS[self.wave]
        cycles = self.cycles(local) + (self.phase / (2 * math.pi) + offset)
        sounding = (times >= self.start) & (times < self.end)
        return np.where(sounding, np.interp(local, self.amplitude_times, self.amplitudes) * oscillator.wave(cycles, 0.0), 0.0)

    def cycles(self, times: FloatArray) -> FloatArray:
        """Cycles since the start at ``times`` (seconds from the start, n)."""
        return Automation(self.frequency_times, self.frequencies).integral(times)

    def part(self, begin: float, end: float) -> Carrier:
        """The carrier from ``begin`` to ``end`` seconds after its start."""

        def keys(times: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
            inside = (times > begin) & (times < end)
            ends = np.interp([begin, end], times, values)
            return np.concatenate([[0.0], times[inside] - begin, [end - begin]]), np.concatenate([ends[:1], values[inside], ends[1:]])

        return Carrier(
            self.start + begin,
            self.start + end,
            (self.phase + 2 * math.pi * float(self.cycles(np.array([begin]))[0])) % (2 * math.pi),
            *keys(self.amplitude_times, self.amplitudes),
            *keys(self.frequency_times, self.frequencies),
            self.wave,
        )

    def to_signal(self) -> Signal:
        """An oscillator with a keyed frequency times a keyed envelope, which can be edited."""
        oscillator, offset = _OSCILLATORS[self.wave]
        keyed = replace(
            oscillator, frequency=_automation(self.frequency_times, self.frequencies), phase=self.phase / (2 * math.pi) + offset
        )
        length = self.end - self.start
        before = self.amplitude_times < length
        times = np.append(self.amplitude_times[before], length)
        values = np.append(self.amplitudes[before], np.interp(length, self.amplitude_times, self.amplitudes))
        signal = keyed * Keyed(Automation(times, values))
        return Delay(signal, self.start) if self.start else signal


def _automation(times: FloatArray, values: FloatArray) -> float | Automation:
    return float(values[0]) if (values == values[0]).all() else Automation(times, values)


def rendered(carriers: Iterable[Carrier], count: int, sample_rate: float) -> FloatArray:
    """The sum of the carriers as ``count`` samples from time 0."""
    samples = np.zeros(count)
    for carrier in carriers:
        first = max(math.ceil(carrier.start * sample_rate), 0)
        last = min(math.ceil(carrier.end * sample_rate), count)
        if first < last:
            samples[first:last] += carrier.at(np.arange(first, last) / sample_rate)
    return samples
