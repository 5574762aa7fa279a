"""Envelopes: signals that are multiplied with others."""

from __future__ import annotations

import math
from dataclasses import MISSING, field
from functools import lru_cache
from typing import ClassVar

import numpy as np

from ..arrays import FloatArray
from ..declaration import Declaration, declare
from ..frozen import frozen
from .automation import Automation, largest, parameter
from .base import Signal
from .limits import MAX_PEAK, MAX_SECONDS, MIN_SECONDS

SILENCE = 1e-4
"""Fraction of its initial value at which an exponential decay ends (-80 dB)."""


@frozen
class Constant(Signal, kind="constant"):
    """One value for `duration` seconds (endless by default); with a duration, a rectangular
    gate."""

    value: float = parameter(1.0, "Value of constant", -MAX_PEAK, MAX_PEAK)
    duration: float = parameter(
        math.inf,
        "Seconds that constant lasts; without it, endless",
        MIN_SECONDS,
        MAX_SECONDS,
        optional=True,
    )

    @property
    def peak(self) -> float:
        return abs(self.value)

    def values(self, times: FloatArray, step: float) -> FloatArray:
        return np.full(times.shape, self.value)


@frozen
class Adsr(Signal, kind="adsr"):
    """Rises to 1 in `attack` seconds, falls to `sustain` (0 to 1) in `decay`, stays for `hold`,
    falls to 0 in `release`.

    `hold` is endless by default.
    """

    peak: ClassVar[float] = 1.0

    attack: float = parameter(0.01, "Seconds in which adsr rises to 1", 0.0, MAX_SECONDS / 4)
    decay: float = parameter(0.05, "Seconds in which adsr falls to sustain", 0.0, MAX_SECONDS / 4)
    sustain: float = parameter(0.7, "Level that adsr holds", 0.0, 1.0)
    release: float = parameter(0.1, "Seconds in which adsr falls to 0", 0.0, MAX_SECONDS / 4)
    hold: float = parameter(
        math.inf,
        "Seconds for which adsr stays at sustain; without it, endless",
        0.0,
        MAX_SECONDS / 4,
        optional=True,
    )

    def __post_init__(self) -> None:
        Signal.__post_init__(self)
        if self.duration < MIN_SECONDS:
            raise ValueError("attack: the envelope takes no time at all")

    @property
    def duration(self) -> float:
        return self.attack + self.decay + self.hold + self.release

    def values(self, times: FloatArray, step: float) -> FloatArray:
        return _lines(self).at(times)


@lru_cache(maxsize=256)
def _lines(envelope: Adsr) -> Automation:
    """The straight lines of an envelope; an endless one stays at its last key."""
    sustain, hold = envelope.sustain, envelope.hold
    keys = [(0.0, 0.0), (envelope.attack, 1.0), (envelope.decay, sustain)]
    if hold < math.inf:
        keys += [(hold, sustain), (envelope.release, 0.0)]
    lengths, levels = np.array(keys).T
    return Automation(lengths.cumsum(), levels)


@frozen
class Keyed(Signal, kind="keyed"):
    """Straight lines between keys, ending at the last one; constant before the first."""

    automation: Automation = field(metadata=declare(MISSING, Declaration(key="track")).metadata)

    def __post_init__(self) -> None:
        if not isinstance(self.automation, Automation):
            raise ValueError("track: must be an Automation")
        if self.peak > MAX_PEAK:
            raise ValueError(f"track: must be within ±{MAX_PEAK:g}, not {self.peak:g}")
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


@frozen
class Decay(Signal, kind="decay"):
    """exp(-t / time_constant), ending when it has fallen by 80 dB."""

    peak: ClassVar[float] = 1.0

    time_constant: float = parameter(
        1.0, "Seconds in which decay falls by a factor e", MIN_SECONDS, MAX_SECONDS
    )

    @property
    def duration(self) -> float:
        return -math.log(SILENCE) * self.time_constant

    def values(self, times: FloatArray, step: float) -> FloatArray:
        return np.exp(times / -self.time_constant)
