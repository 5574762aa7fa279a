"""The base class of all signals, and the signals that are made of others."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import MISSING, Field, field, fields
from functools import lru_cache, reduce
from typing import Any, ClassVar

import numpy as np

from ..arrays import FloatArray
from ..declaration import Declaration, Declared, declare, declared
from ..forms import JsonObject
from ..frozen import frozen
from .automation import Automation, largest, parameter, values_of
from .limits import MAX_PEAK, MAX_SECONDS, MIN_SECONDS


def sample_times(start: int, count: int, sample_rate: float, onset: float) -> FloatArray:
    """Return the times of samples `start` to `start + count - 1` since `onset`, shape (count,),
    read-only."""
    return (_known_times if count <= _SHORT else _times)(start, count, sample_rate, onset)


def _times(start: int, count: int, sample_rate: float, onset: float) -> FloatArray:
    times = np.arange(start, start + count) / sample_rate - onset
    times.setflags(write=False)
    return times


_SHORT = 8192
# Many signals of a scene are sampled at the same times.
_known_times = lru_cache(maxsize=32)(_times)


class Signal(Declared, ABC):
    """An immutable function of time in seconds, 0 before its beginning and after its end.

    `a * b` is the product (an envelope times an oscillator), `a * 0.5` a gain, `a + b` the sum, `a
    >> b` first `a`, then `b`. A subclass is a frozen dataclass. Its JSON form is its fields and the
    name `kind`. Its constructor raises ValueError that names the field if its declaration rejects a
    value.
    """

    __slots__ = ()

    kind: ClassVar[str]

    def __init_subclass__(cls, kind: str = "") -> None:
        if kind:
            cls.kind = kind

    @property
    @abstractmethod
    def duration(self) -> float:
        """Seconds until the signal ends for good; `math.inf` for an endless one."""

    @property
    @abstractmethod
    def peak(self) -> float:
        """A bound that no sample exceeds in magnitude."""

    @abstractmethod
    def values(self, times: FloatArray, step: float) -> FloatArray:
        """Return the values at `times`, all within [0, duration), for samples that are `step`
        seconds apart.

        A value depends only on its own time. `step` bounds the frequencies that samples can carry:
        components that would alias are left out.
        """

    def at(self, times: FloatArray, step: float) -> FloatArray:
        """Return the values at `times` (seconds from the signal's beginning, shape (n,), any
        order): zero outside [0, duration)."""
        if times.size == 0:
            return np.zeros(0)
        duration = self.duration
        if times.min() >= 0.0 and times.max() < duration:
            return self.values(times, step)
        result = np.zeros(times.shape)
        inside = (times >= 0.0) & (times < duration)
        if inside.any():
            result[inside] = self.values(times[inside], step)
        return result

    def sample(self, start: int, count: int, sample_rate: float, onset: float = 0.0) -> FloatArray:
        """Return samples `start` to `start + count - 1`, shape (count,).

        Sample n lies at n / sample_rate seconds on a clock on which the signal begins at `onset`
        (any real number: no rounding to samples). Two calls give the same sample wherever their
        blocks begin. The array is the caller's own.
        """
        if not sample_rate > 0:
            raise ValueError(f"sample_rate: must be positive, not {sample_rate:g}")
        if count < 0:
            raise ValueError(f"count: must not be negative, not {count}")
        times = sample_times(start, count, sample_rate, onset)
        first, last = np.searchsorted(times, (0.0, self.duration)).tolist()
        if last - first == count:
            return self.values(times, 1.0 / sample_rate)
        result = np.zeros(count)
        if first < last:
            result[first:last] = self.values(times[first:last], 1.0 / sample_rate)
        return result

    def to_dict(self) -> JsonObject:
        """Return the JSON form: {"signal": kind, field: value, ...}. Infinite values are left
        out."""
        result: JsonObject = {"signal": self.kind}
        for key, entry in json_fields(type(self)).items():
            value = getattr(self, entry.name)
            if value is not None and not (isinstance(value, float) and value == math.inf):
                result[key] = _to_json(value)
        return result

    def __mul__(self, other: Signal | float | Automation) -> Signal:
        return Product((self, other)) if isinstance(other, Signal) else Gain(self, other)

    __rmul__ = __mul__

    def __add__(self, other: Signal) -> Signal:
        return Sum((self, other)) if isinstance(other, Signal) else NotImplemented

    def __rshift__(self, other: Signal) -> Signal:
        return Sequence((self, other)) if isinstance(other, Signal) else NotImplemented


class Amplified(Signal):
    """Base of signals of a magnitude of at most their `amplitude`, a number or an automation."""

    __slots__ = ()

    amplitude: float | Automation

    @property
    def peak(self) -> float:
        return largest(self.amplitude)


def json_fields(cls: type[Signal]) -> dict[str, Field[Any]]:
    """Return the fields of a kind of signal by their keys in its JSON form."""
    keys = {name: item.key for name, item in declared(cls).items()}
    return {keys.get(entry.name) or entry.name: entry for entry in fields(cls) if entry.init}  # type: ignore[arg-type]


@frozen(kw_only=True)
class Operands(Declaration):
    """The signal that another one is made of, or a tuple of ``many``."""

    many: bool = False

    def checked(self, value: Any) -> Any:
        if self.many and not (isinstance(value, tuple) and value):
            raise ValueError("must be a tuple of at least one signal")
        for part in value if self.many else (value,):
            if not isinstance(part, Signal):
                raise ValueError(f"must be a signal, not {type(part).__name__}")
        return value

    def schema(self) -> JsonObject:
        return {"type": "array" if self.many else "object"}


SIGNAL = declare(MISSING, Operands()).metadata
"""Metadata of a field that is a signal."""


@frozen
class Combined(Signal):
    """Base of signals that are made of several others."""

    of: tuple[Signal, ...] = field(metadata=declare(MISSING, Operands(many=True)).metadata)


def _to_json(value: object) -> object:
    if isinstance(value, Signal):
        return value.to_dict()
    if isinstance(value, Automation):
        return {"times": value.times.tolist(), "values": value.values.tolist()}
    if isinstance(value, tuple):
        return [part.to_dict() for part in value]
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value


@frozen
class Gain(Signal, kind="gain"):
    """`of` times `gain`, a number or an automation over the signal's own time."""

    of: Signal = field(metadata=SIGNAL)
    gain: float | Automation = parameter(1.0, "Factor of gain", -MAX_PEAK, MAX_PEAK, keyed=True)

    def __post_init__(self) -> None:
        Signal.__post_init__(self)
        _check_peak("gain", self.peak)

    @property
    def duration(self) -> float:
        return self.of.duration

    @property
    def peak(self) -> float:
        return self.of.peak * largest(self.gain)

    def values(self, times: FloatArray, step: float) -> FloatArray:
        return self.of.values(times, step) * values_of(self.gain, times)


@frozen
class Modified(Signal):
    """Base of signals that are made of another one and do not exceed its peak."""

    of: Signal = field(metadata=SIGNAL)

    @property
    def peak(self) -> float:
        return self.of.peak


@frozen
class Product(Combined, kind="product"):
    """The product of `of`, as long as the shortest."""

    def __post_init__(self) -> None:
        Signal.__post_init__(self)
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
        return reduce(np.multiply, (factor.values(times, step) for factor in self.of))


@frozen
class Sum(Combined, kind="sum"):
    """The sum of `of`, as long as the longest."""

    def __post_init__(self) -> None:
        Signal.__post_init__(self)
        _check_peak("of", self.peak)

    @property
    def duration(self) -> float:
        return max(term.duration for term in self.of)

    @property
    def peak(self) -> float:
        return sum(term.peak for term in self.of)

    def values(self, times: FloatArray, step: float) -> FloatArray:
        return reduce(np.add, (term.at(times, step) for term in self.of))


@frozen
class Sequence(Combined, kind="sequence"):
    """`of` one after the other; only the last may be endless."""

    def __post_init__(self) -> None:
        Signal.__post_init__(self)
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
            result[chosen] = values_inside(self.of[number], times[chosen] - begin, step)
        return result


def values_inside(signal: Signal, times: FloatArray, step: float) -> FloatArray:
    """Return the signal's values at times that are within its duration up to rounding."""
    return signal.values(np.clip(times, 0.0, np.nextafter(signal.duration, 0.0)), step)


@frozen
class Delay(Modified, kind="delay"):
    """`of`, `seconds` later."""

    seconds: float = parameter(0.0, "Seconds by which delay starts later", 0.0, MAX_SECONDS)

    @property
    def duration(self) -> float:
        return self.seconds + self.of.duration

    def values(self, times: FloatArray, step: float) -> FloatArray:
        return self.of.at(times - self.seconds, step)


@frozen
class Loop(Modified, kind="loop"):
    """`of` repeated `count` times or without end.

    crossfade: seconds, at most half of the signal: each pass fades in while the end of the one
    before fades out, so that a recording loops without a click; a pass then begins that much before
    the end of the last.
    """

    count: int | None = parameter(
        None, "Times that loop plays; without it, endlessly", 1, 10**9, whole=True, optional=True
    )
    crossfade: float = parameter(
        0.0, "Seconds for which the passes of loop overlap", 0.0, MAX_SECONDS
    )

    def __post_init__(self) -> None:
        Modified.__post_init__(self)
        if not MIN_SECONDS <= self.of.duration <= MAX_SECONDS:
            raise ValueError(f"of: a looped signal must end, after {MIN_SECONDS:g} seconds or more")
        if self.crossfade > self.of.duration / 2:
            raise ValueError(
                f"crossfade: must be from 0 to {self.of.duration / 2:g}, not {self.crossfade:g}"
            )

    @property
    def period(self) -> float:
        """Seconds from the beginning of a pass to that of the next."""
        return self.of.duration - self.crossfade

    @property
    def duration(self) -> float:
        return math.inf if self.count is None else self.count * self.period + self.crossfade

    def values(self, times: FloatArray, step: float) -> FloatArray:
        period = self.period
        passes = np.floor(times / period)
        if self.count is not None:
            passes = np.minimum(passes, self.count - 1)
        local = times - passes * period
        result = values_inside(self.of, local, step)
        if self.crossfade:
            seam = (local < self.crossfade) & (passes > 0)
            if seam.any():
                share = np.maximum(local[seam], 0.0) / self.crossfade
                result[seam] = share * result[seam] + (1.0 - share) * values_inside(
                    self.of, local[seam] + period, step
                )
        return result


def _check_peak(name: str, peak: float) -> None:
    if not peak <= MAX_PEAK:
        raise ValueError(f"{name}: the signal would exceed {MAX_PEAK:g}")
