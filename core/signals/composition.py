"""Signals made of signals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..arrays import FloatArray
from .automation import Track, checked_parameter, largest, values_of
from .limits import MAX_PEAK, MAX_SECONDS, MIN_SECONDS, checked_integer, checked_number
from .signal import Signal


@dataclass(frozen=True, slots=True)
class Gain(Signal):
    """`of` times `gain`, a number or a track over the signal's own time."""

    kind: ClassVar[str] = "gain"

    of: Signal
    gain: float | Track = 1.0

    def __post_init__(self) -> None:
        _check_signal("of", self.of)
        object.__setattr__(self, "gain", checked_parameter("gain", self.gain, -MAX_PEAK, MAX_PEAK))
        _check_peak("gain", self.peak)

    @property
    def duration(self) -> float:
        return self.of.duration

    @property
    def peak(self) -> float:
        return self.of.peak * largest(self.gain)

    def values(self, times: FloatArray, step: float) -> FloatArray:
        return self.of.values(times, step) * values_of(self.gain, times)

    def sample(self, start: int, count: int, sample_rate: float, onset: float = 0.0) -> FloatArray:
        samples = self.of.sample(start, count, sample_rate, onset)
        if isinstance(self.gain, Track):
            return samples * self.gain.at(np.arange(start, start + count) / sample_rate - onset)
        return samples * self.gain


@dataclass(frozen=True, slots=True)
class Delay(Signal):
    """`of`, `seconds` later."""

    kind: ClassVar[str] = "delay"

    of: Signal
    seconds: float = 0.0

    def __post_init__(self) -> None:
        _check_signal("of", self.of)
        object.__setattr__(self, "seconds", checked_number("seconds", self.seconds, 0.0, MAX_SECONDS))

    @property
    def duration(self) -> float:
        return self.seconds + self.of.duration

    @property
    def peak(self) -> float:
        return self.of.peak

    def values(self, times: FloatArray, step: float) -> FloatArray:
        return self.of.at(times - self.seconds, step)


@dataclass(frozen=True, slots=True)
class Product(Signal):
    """The product of `of`, as long as the shortest."""

    kind: ClassVar[str] = "product"

    of: tuple[Signal, ...]

    def __post_init__(self) -> None:
        _check_signals(self.of)
        peak = 1.0
        for factor in self.of:
            peak *= factor.peak
            _check_peak("of", peak)

    @property
    def duration(self) -> float:
        return min(factor.duration for factor in self.of)

    @property
    def peak(self) -> float:
        return math.prod(factor.peak for factor in self.of)

    def values(self, times: FloatArray, step: float) -> FloatArray:
        result = self.of[0].values(times, step)
        for factor in self.of[1:]:
            result = result * factor.values(times, step)
        return result

    def sample(self, start: int, count: int, sample_rate: float, onset: float = 0.0) -> FloatArray:
        result = self.of[0].sample(start, count, sample_rate, onset)
        for factor in self.of[1:]:
            result *= factor.sample(start, count, sample_rate, onset)
        return result


@dataclass(frozen=True, slots=True)
class Sum(Signal):
    """The sum of `of`, as long as the longest."""

    kind: ClassVar[str] = "sum"

    of: tuple[Signal, ...]

    def __post_init__(self) -> None:
        _check_signals(self.of)
        _check_peak("of", self.peak)

    @property
    def duration(self) -> float:
        return max(term.duration for term in self.of)

    @property
    def peak(self) -> float:
        return sum(term.peak for term in self.of)

    def values(self, times: FloatArray, step: float) -> FloatArray:
        result = self.of[0].at(times, step)
        for term in self.of[1:]:
            result = result + term.at(times, step)
        return result

    def sample(self, start: int, count: int, sample_rate: float, onset: float = 0.0) -> FloatArray:
        result = self.of[0].sample(start, count, sample_rate, onset)
        for term in self.of[1:]:
            result += term.sample(start, count, sample_rate, onset)
        return result


@dataclass(frozen=True, slots=True)
class Sequence(Signal):
    """`of` one after the other; only the last may be endless."""

    kind: ClassVar[str] = "sequence"

    of: tuple[Signal, ...]

    def __post_init__(self) -> None:
        _check_signals(self.of)
        if any(part.duration == math.inf for part in self.of[:-1]):
            raise ValueError("of: only the last signal of a sequence may be endless")

    @property
    def duration(self) -> float:
        return sum(part.duration for part in self.of)

    @property
    def peak(self) -> float:
        return max(part.peak for part in self.of)

    def values(self, times: FloatArray, step: float) -> FloatArray:
        result = np.empty(times.shape)
        ends = np.cumsum([part.duration for part in self.of])
        which = np.minimum(np.searchsorted(ends, times, side="right"), len(self.of) - 1)
        for number in np.unique(which):
            chosen = which == number
            begin = ends[number - 1] if number else 0.0
            result[chosen] = _inside(self.of[number], times[chosen] - begin, step)
        return result


@dataclass(frozen=True, slots=True)
class Loop(Signal):
    """`of` again and again, `count` times or without end.

    crossfade: seconds, at most half of the signal: each pass fades in while the end of the one before fades out, so that a recording
    loops without a click; a pass then begins that much before the end of the last.
    """

    kind: ClassVar[str] = "loop"

    of: Signal
    count: int | None = None
    crossfade: float = 0.0

    def __post_init__(self) -> None:
        _check_signal("of", self.of)
        if not MIN_SECONDS <= self.of.duration <= MAX_SECONDS:
            raise ValueError("of: a looped signal must end")
        if self.count is not None:
            object.__setattr__(self, "count", checked_integer("count", self.count, 1, 10**9))
        object.__setattr__(self, "crossfade", checked_number("crossfade", self.crossfade, 0.0, self.of.duration / 2))

    @property
    def period(self) -> float:
        """Seconds from the beginning of a pass to that of the next."""
        return self.of.duration - self.crossfade

    @property
    def duration(self) -> float:
        return math.inf if self.count is None else self.count * self.period + self.crossfade

    @property
    def peak(self) -> float:
        return self.of.peak

    def values(self, times: FloatArray, step: float) -> FloatArray:
        period = self.period
        passes = np.floor(times / period)
        if self.count is not None:
            passes = np.minimum(passes, self.count - 1)
        local = times - passes * period
        result = _inside(self.of, local, step)
        if self.crossfade:
            seam = (local < self.crossfade) & (passes > 0)
            if seam.any():
                share = np.maximum(local[seam], 0.0) / self.crossfade
                result[seam] = share * result[seam] + (1.0 - share) * _inside(self.of, local[seam] + period, step)
        return result


def _inside(signal: Signal, times: FloatArray, step: float) -> FloatArray:
    """Return the signal's values at times that are inside but for rounding."""
    return signal.values(np.clip(times, 0.0, np.nextafter(signal.duration, 0.0)), step)


def _check_signal(name: str, value: object) -> None:
    if not isinstance(value, Signal):
        raise ValueError(f"{name}: must be a signal, not {type(value).__name__}")


def _check_signals(of: object) -> None:
    if not isinstance(of, tuple) or not of:
        raise ValueError("of: must be a tuple of at least one signal")
    for number, part in enumerate(of):
        _check_signal(f"of[{number}]", part)


def _check_peak(name: str, peak: float) -> None:
    if not peak <= MAX_PEAK:
        raise ValueError(f"{name}: the signal would exceed {MAX_PEAK:g}")
