"""Envelopes: signals that are multiplied with others."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import ClassVar

import numpy as np

from ..arrays import FloatArray
from .automation import Automation, checked_parameter, largest
from .base import Signal
from .limits import MAX_PEAK, MAX_SECONDS, MIN_SECONDS, checked_number

SILENCE = 1e-4
"""Fraction of its initial value at which an exponential decay ends (-80 dB)."""


@dataclass(frozen=True, slots=True)
class Constant(Signal):
    """One value for `duration` seconds (endless by default); with a duration, a rectangular gate."""

    kind: ClassVar[str] = "constant"

    value: float = 1.0
    duration: float = math.inf

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", checked_number("value", self.value, -MAX_PEAK, MAX_PEAK))
        if self.duration != math.inf:
            object.__setattr__(self, "duration", checked_number("duration", self.duration, MIN_SECONDS, MAX_SECONDS))

    @property
    def peak(self) -> float:
        return abs(self.value)

    def values(self, times: FloatArray, step: float) -> FloatArray:
        return np.full(times.shape, self.value)


@dataclass(frozen=True, slots=True)
class Adsr(Signal):
    """Rises to 1 in `attack` seconds, falls to `sustain` (0 to 1) in `decay`, stays for `hold`, falls to 0 in `release`.

    `hold` is endless by default.
    """

    kind: ClassVar[str] = "adsr"

    attack: float = 0.01
    decay: float = 0.05
    sustain: float = 0.7
    release: float = 0.1
    hold: float = math.inf

    def __post_init__(self) -> None:
        for name in ("attack", "decay", "release"):
            object.__setattr__(self, name, checked_number(name, getattr(self, name), 0.0, MAX_SECONDS / 4))
        object.__setattr__(self, "sustain", checked_number("sustain", self.sustain, 0.0, 1.0))
        if self.hold != math.inf:
            object.__setattr__(self, "hold", checked_number("hold", self.hold, 0.0, MAX_SECONDS / 4))
        if self.duration < MIN_SECONDS:
            raise ValueError("attack: the envelope takes no time at all")

    @property
    def duration(self) -> float:
        return self.attack + self.decay + self.hold + self.release

    @property
    def peak(self) -> float:
        return 1.0

    def values(self, times: FloatArray, step: float) -> FloatArray:
        sustained = _rise_and_fall(self.attack, self.decay, self.sustain).at(times)
        if self.hold == math.inf:
            return sustained
        return sustained * _release(self.duration - self.release, self.duration).at(times)


@lru_cache(maxsize=256)
def _rise_and_fall(attack: float, decay: float, sustain: float) -> Automation:
    return Automation(np.cumsum((0.0, attack, decay)), (0.0, 1.0, sustain))


@lru_cache(maxsize=256)
def _release(start: float, end: float) -> Automation:
    return Automation((start, end), (1.0, 0.0))


@dataclass(frozen=True, slots=True)
class Keyed(Signal):
    """Straight lines between keys, ending at the last one; constant before the first."""

    kind: ClassVar[str] = "keyed"

    automation: Automation = field(metadata={"key": "track"})

    def __post_init__(self) -> None:
        if not isinstance(self.automation, Automation):
            raise ValueError("track: must be an Automation")
        checked_parameter("track", self.automation, -MAX_PEAK, MAX_PEAK)
        if self.duration < MIN_SECONDS:
            raise ValueError("track: its last key must be after the beginning")

    @property
    def duration(self) -> float:
        return float(self.automation.times[-1])

    @property
    def peak(self) -> float:
        return largest(self.automation)

    def values(self, times: FloatArray, step: float) -> FloatArray:
        return self.automation.at(times)


@dataclass(frozen=True, slots=True)
class Decay(Signal):
    """exp(-t / time_constant), ending when it has fallen by 80 dB."""

    kind: ClassVar[str] = "decay"

    time_constant: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "time_constant", checked_number("time_constant", self.time_constant, MIN_SECONDS, MAX_SECONDS))

    @property
    def duration(self) -> float:
        return -math.log(SILENCE) * self.time_constant

    @property
    def peak(self) -> float:
        return 1.0

    def values(self, times: FloatArray, step: float) -> FloatArray:
        return np.exp(times / -self.time_constant)
