"""Signals of an impact: the shock and the ringing after it."""

from __future__ import annotations

import math

import numpy as np

from ..arrays import FloatArray
from ..frozen import frozen
from .automation import parameter
from .base import Amplified
from .envelopes import SILENCE
from .limits import MAX_FREQUENCY, MAX_PEAK, MAX_SECONDS, MIN_SECONDS
from .oscillators import sine


@frozen
class Impulse(Amplified, kind="impulse"):
    """A half-sine shock pulse, the force of a contact that lasts `width` seconds: amplitude · sin(π
    t / width)."""

    width: float = parameter(0.002, "Seconds that a shock pulse lasts", 0.0005, MAX_SECONDS)
    amplitude: float = parameter(1.0, "Largest value", -MAX_PEAK, MAX_PEAK)

    @property
    def duration(self) -> float:
        return self.width

    def values(self, times: FloatArray, step: float) -> FloatArray:
        return self.amplitude * sine(times * (0.5 / self.width))


@frozen
class DecayingSine(Amplified, kind="decaying_sine"):
    """amplitude · exp(-t / decay) · sin(2π frequency t), ending when it has fallen by 80 dB.

    frequency: hertz; silent at and above half the sample rate. decay: seconds, the time constant.
    """

    frequency: float = parameter(150.0, "Hertz", 0.0, MAX_FREQUENCY)
    decay: float = parameter(
        0.03, "Seconds in which a decaying sine falls by a factor e", MIN_SECONDS, MAX_SECONDS
    )
    amplitude: float = parameter(1.0, "Largest value", -MAX_PEAK, MAX_PEAK)

    @property
    def duration(self) -> float:
        return -math.log(SILENCE) * self.decay

    def values(self, times: FloatArray, step: float) -> FloatArray:
        if self.frequency * step >= 0.5:
            return np.zeros(times.shape)
        result = np.exp(times / -self.decay)
        result *= sine(self.frequency * times)
        result *= self.amplitude
        return result
