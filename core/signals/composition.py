"""Delayed and repeated signals."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..arrays import FloatArray
from .base import Modified, values_inside
from .limits import MAX_SECONDS, MIN_SECONDS, checked_integer, checked_number, within


@dataclass(frozen=True, slots=True)
class Delay(Modified, kind="delay"):
    """`of`, `seconds` later."""

    seconds: float = field(default=0.0, metadata=within(0.0, MAX_SECONDS))

    @property
    def duration(self) -> float:
        return self.seconds + self.of.duration

    def values(self, times: FloatArray, step: float) -> FloatArray:
        return self.of.at(times - self.seconds, step)


@dataclass(frozen=True, slots=True)
class Loop(Modified, kind="loop"):
    """`of` repeated `count` times or without end.

    crossfade: seconds, at most half of the signal: each pass fades in while the end of the one before fades out, so that a recording
    loops without a click; a pass then begins that much before the end of the last.
    """

    count: int | None = field(default=None, metadata=within(1, 10**9, checked_integer))
    crossfade: float = 0.0

    def __post_init__(self) -> None:
        Modified.__post_init__(self)
        if not MIN_SECONDS <= self.of.duration <= MAX_SECONDS:
            raise ValueError(f"of: a looped signal must end, after {MIN_SECONDS:g} seconds or more")
        object.__setattr__(self, "crossfade", checked_number("crossfade", self.crossfade, 0.0, self.of.duration / 2))

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
                result[seam] = share * result[seam] + (1.0 - share) * values_inside(self.of, local[seam] + period, step)
        return result
