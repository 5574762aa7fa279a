"""What every signal is: a value over time that composes and is sampled only at the end."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from ..arrays import FloatArray
from .automation import Track


def sample_times(start: int, count: int, sample_rate: float, onset: float) -> FloatArray:
    """Return the times of samples `start` to `start + count - 1` since `onset`, shape (count,), not to be written to."""
    return (_known_times if count <= _SHORT else _times)(start, count, sample_rate, onset)


def _times(start: int, count: int, sample_rate: float, onset: float) -> FloatArray:
    times = np.arange(start, start + count) / sample_rate - onset
    times.setflags(write=False)
    return times


_SHORT = 8192
# Many signals of a scene are sampled at the same times.
_known_times = lru_cache(maxsize=32)(_times)


class Signal(ABC):
    """An immutable function of time in seconds, 0 before its beginning and after its end.

    `a * b` is the product (an envelope times an oscillator), `a * 0.5` a gain, `a + b` the sum, `a >> b` first `a`, then `b`.
    A subclass is a frozen dataclass whose fields, under the name in `kind`, are its JSON form.
    """

    __slots__ = ()

    kind: ClassVar[str]

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
        """Return the values at `times`, all within [0, duration), for samples that are `step` seconds apart.

        A value depends on its own time alone. `step` tells what the samples can carry: what would alias is left out.
        """

    def at(self, times: FloatArray, step: float) -> FloatArray:
        """Return the values at `times` (seconds from the signal's beginning, shape (n,), any order): zero outside [0, duration)."""
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

        Sample n lies at n / sample_rate seconds on a clock on which the signal begins at `onset` (any real number: no rounding to samples).
        Two calls give the same sample wherever their blocks begin. The array is the caller's own.
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

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form: {"signal": kind, field: value, ...}."""
        from .serialization import signal_to_dict

        return signal_to_dict(self)

    def __mul__(self, other: Signal | float | Track) -> Signal:
        from .composition import Gain, Product

        return Product((self, other)) if isinstance(other, Signal) else Gain(self, other)

    __rmul__ = __mul__

    def __add__(self, other: Signal) -> Signal:
        from .composition import Sum

        return Sum((self, other)) if isinstance(other, Signal) else NotImplemented

    def __rshift__(self, other: Signal) -> Signal:
        from .composition import Sequence

        return Sequence((self, other)) if isinstance(other, Signal) else NotImplemented
