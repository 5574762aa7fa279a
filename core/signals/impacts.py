"""Signals of an impact: the shock and the ringing after it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..arrays import FloatArray
from .base import Signal
from .envelopes import SILENCE
from .limits import MAX_FREQUENCY, MAX_PEAK, MAX_SECONDS, MIN_SECONDS, checked_number
from .oscillators import sine


@dataclass(frozen=True, slots=True)
class Impulse(Signal):
    """A half-sine shock pulse, the force of a contact that lasts `width` seconds: amplitude · sin(π t / width)."""

    kind: ClassVar[str] = "impulse"

    width: float = 0.002
    amplitude: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "width", checked_number("width", self.width, 0.0005, MAX_SECONDS))
        object.__setattr__(self, "amplitude", checked_number("amplitude", self.amplitude, -MAX_PEAK, MAX_PEAK))

    @property
    def duration(self) -> float:
        return self.width

    @property
    def peak(self) -> float:
        return abs(self.amplitude)

    def values(self, times: FloatArray, step: float) -> FloatArray:
        return self.amplitude * sine(times * (0.5 / self.width))


@dataclass(frozen=True, slots=True)
class DecayingSine(Signal):
    """amplitude · exp(-t / decay) · sin(2π frequency t), ending when it has fallen by 80 dB.

    frequency: hertz; silent at and above half the sample rate. decay: seconds, the time constant.
    """

    kind: ClassVar[str] = "decaying_sine"

    frequency: float = 150.0
    decay: float = 0.03
    amplitude: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "frequency", checked_number("frequency", self.frequency, 0.0, MAX_FREQUENCY))
        object.__setattr__(self, "decay", checked_number("decay", self.decay, MIN_SECONDS, MAX_SECONDS))
        object.__setattr__(self, "amplitude", checked_number("amplitude", self.amplitude, -MAX_PEAK, MAX_PEAK))

    @property
    def duration(self) -> float:
        return -math.log(SILENCE) * self.decay

    @property
    def peak(self) -> float:
        return abs(self.amplitude)

    def values(self, times: FloatArray, step: float) -> FloatArray:
        if self.frequency * step >= 0.5:
            return np.zeros(times.shape)
        result = np.exp(times / -self.decay)
        result *= sine(self.frequency * times)
        result *= self.amplitude
        return result
