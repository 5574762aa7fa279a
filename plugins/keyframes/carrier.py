"""A keyframed oscillation: amplitude and frequency are linear between keys."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ...core.arrays import FloatArray, IntArray
from ...core.formats.tracks.listener_tracks import CHUNK
from ...core.frozen import frozen
from ...core.signals import Automation, Delay, Keyed, Saw, Signal, Sine, Square, Triangle
from ...core.signals.oscillators import Oscillator
from .comparison import Comparison

_OSCILLATORS: dict[str, tuple[Oscillator, float]] = {
    "sine": (Sine(), 0.0),
    "square": (Square(), 0.0),
    "triangle": (Triangle(), 0.0),
    "saw": (Saw(), 0.5),
}
"""Waves by name, with the cycles to add so that each begins at 0 (a square at its edge) and
rises."""


_OBJECT_BYTES = 800


@frozen(eq=False)
class Carrier:
    """``a(t) sin(phase + 2π ∫ f dt)``, or another wave of that phase, from ``start`` to ``end``
    (seconds), silent elsewhere.

    phase: radians at the start. amplitude_times, amplitudes (n,) and frequency_times, frequencies
    (m,): keys, n and m >= 1, in seconds from the start, never decreasing, hertz; the values are
    constant before the first key and after the last. wave: sine, square, triangle or saw.
    """

    start: float
    end: float
    phase: float
    amplitude_times: FloatArray
    amplitudes: FloatArray
    frequency_times: FloatArray
    frequencies: FloatArray
    wave: str = "sine"

    @property
    def size(self) -> int:
        """Bytes in memory."""
        return 16 * (len(self.amplitudes) + len(self.frequencies)) + _OBJECT_BYTES

    def sampled(self, times: FloatArray, rate: float) -> FloatArray:
        """The values at evenly spaced ``times`` (seconds, at least one), all within the carrier."""
        local = times - self.start
        oscillator, offset = _OSCILLATORS[self.wave]
        cycles = _integral(self.frequency_times, self.frequencies, local, rate)
        cycles += self.phase / (2 * math.pi) + offset
        values = oscillator.wave(cycles, 0.0)
        values *= _line(self.amplitude_times, self.amplitudes, local, rate)
        return values

    def cycles(self, times: FloatArray) -> FloatArray:
        """Cycles since the start at ``times`` (seconds from the start, n)."""
        return Automation(self.frequency_times, self.frequencies).integral(times)

    def part(self, begin: float, end: float) -> Carrier:
        """The carrier from ``begin`` to ``end`` seconds after its start."""

        def keys(times: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
            # Two keys at one time are a jump: the part begins after it, or ends before it.
            first = np.searchsorted(times, begin, side="right")
            last = np.searchsorted(times, end, side="left")
            low, high = np.interp([begin, end], times, values)
            low = values[first - 1] if first and times[first - 1] == begin else low
            high = values[last] if last < len(times) and times[last] == end else high
            inside = slice(first, last)
            return np.concatenate([[0.0], times[inside] - begin, [end - begin]]), np.concatenate(
                [[low], values[inside], [high]]
            )

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
        frequency = self.frequencies
        is_steady = (self.frequencies == self.frequencies[0]).all()
        hertz = float(frequency[0]) if is_steady else Automation(self.frequency_times, frequency)
        keyed = replace(oscillator, frequency=hertz, phase=self.phase / (2 * math.pi) + offset)
        length = self.end - self.start
        before = self.amplitude_times < length
        times = np.append(self.amplitude_times[before], length)
        values = np.append(
            self.amplitudes[before], np.interp(length, self.amplitude_times, self.amplitudes)
        )
        signal = keyed * Keyed(Automation(times, values))
        return Delay(signal, self.start) if self.start else signal


def _line(keys: FloatArray, values: FloatArray, times: FloatArray, rate: float) -> FloatArray:
    """The straight lines through keys at evenly spaced times."""
    if len(keys) == 1:
        return np.full(len(times), values[0])
    counts = _counts(keys, times, rate)
    since = _since(keys, times, counts)
    since *= _slopes(keys, values).repeat(counts)
    since += values.repeat(counts)
    return since


def _integral(keys: FloatArray, values: FloatArray, times: FloatArray, rate: float) -> FloatArray:
    """The integral from 0 of the straight lines through keys at evenly spaced times."""
    if len(keys) == 1:
        return np.asarray(times * values[0])
    areas = np.empty(len(keys))
    areas[0] = keys[0] * values[0]
    areas[1:] = areas[0] + ((keys[1:] - keys[:-1]) * (values[1:] + values[:-1]) / 2).cumsum()
    counts = _counts(keys, times, rate)
    # The area at the key before plus that of the line since then, by Horner's rule.
    since = _since(keys, times, counts)
    result = (_slopes(keys, values) / 2).repeat(counts)
    result *= since
    result += values.repeat(counts)
    result *= times - keys.repeat(counts) if times[0] < keys[0] else since
    result += areas.repeat(counts)
    return result


def _since(keys: FloatArray, times: FloatArray, counts: IntArray) -> FloatArray:
    """The time since the key before each of ``times``, 0 before the first one."""
    since = times - keys.repeat(counts)
    return np.maximum(since, 0.0) if times[0] < keys[0] else np.asarray(since)


def _index(time: float, rate: float) -> int:
    """The first sample at or after a time (seconds)."""
    index = math.ceil(time * rate)
    return index + 1 if index / rate < time else index


def _counts(keys: FloatArray, times: FloatArray, rate: float) -> IntArray:
    """How many of the evenly spaced ``times`` follow each key; those before the first key count for
    it."""
    borders = np.empty(len(keys) + 1, dtype=np.int64)
    borders[0] = 0
    borders[-1] = len(times)
    borders[1:-1] = np.minimum(
        np.maximum(np.ceil((keys[1:] - times[0]) * rate - 1e-9), 0), len(times)
    )
    return borders[1:] - borders[:-1]


def _slopes(keys: FloatArray, values: FloatArray) -> FloatArray:
    """Change of the value per second after each key, 0 after the last one and where it jumps."""
    widths = keys[1:] - keys[:-1]
    slopes = np.zeros(len(keys))
    np.divide(values[1:] - values[:-1], widths, out=slopes[:-1], where=widths > 1e-12)
    return slopes


def rendered(carriers: Iterable[Carrier], first: int, last: int, rate: float) -> FloatArray:
    """The sum of the carriers at the times ``first / rate`` to before ``last / rate`` seconds."""
    samples = np.zeros(last - first)
    times = np.arange(first, last) / rate
    for carrier in carriers:
        begin = max(_index(carrier.start, rate), first)
        end = min(_index(carrier.end, rate), last)
        if begin < end:
            samples[begin - first : end - first] += carrier.sampled(
                times[begin - first : end - first], rate
            )
    return samples


def compare_carriers(listener: int, carriers: Iterable[Carrier], measured: Comparison) -> None:
    """Compare the samples of a listener with the carriers that are played instead."""
    player = CarrierPlayer(listener, measured)
    player.add(carriers)
    player.play_until(math.inf)


class CarrierPlayer:
    """Renders the carriers of a listener and hands them to a comparison, in pieces.

    Carriers are added in any order, before the time that they begin at is played.
    """

    def __init__(self, listener: int, measured: Comparison) -> None:
        self._listener, self._measured = listener, measured
        self._carriers: list[Carrier] = []
        self._done = 0

    def add(self, carriers: Iterable[Carrier]) -> None:
        """Add carriers."""
        self._carriers.extend(carriers)

    def play_until(self, time: float) -> None:
        """Compare all samples before ``time`` (seconds); carriers that end before it are
        dropped."""
        tracks, thinning = self._measured.tracks, self._measured.thinning
        count, rate = tracks.count, tracks.sample_rate / thinning
        last = count if math.isinf(time) else min(math.floor(time * rate) * thinning, count)
        while self._done < last:
            first = self._done
            end = min(self._done + CHUNK // thinning * thinning, last)
            played = rendered(self._carriers, first // thinning, -(-end // thinning), rate)
            self._measured.add(self._listener, np.clip(played, -1.0, 1.0))
            self._done = end
            self._carriers = [
                carrier for carrier in self._carriers if carrier.end * tracks.sample_rate > end
            ]
