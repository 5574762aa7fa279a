"""Periodic signals. Phase is the integral of frequency, so sweeps are exact and independent of the
block size."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import ClassVar

import numpy as np

from ..arrays import FloatArray
from ..frozen import frozen
from .automation import Automation, largest, parameter, values_of
from .base import Amplified
from .limits import MAX_FREQUENCY, MAX_PEAK

# sin(2π q) / q in powers of q², the highest first: Chebyshev's fit on |q| <= 1/4, to 7e-16.
_SINE_COEFFICIENTS = (
    -0.6925067010720717, 3.817365633469135, -15.09450614073429, 42.05868995395094,
    -76.70585968962867, 81.60524927557977, -41.341702240398284, 6.283185307179585,
)  # fmt: skip


@frozen
class Oscillator(Amplified):
    """A wave of period 1 over the phase in cycles, from `phase` on.

    frequency: hertz, from 0 to 20,000, a number or an automation. At and above half the sample rate
    the oscillator is silent. amplitude: a number or an automation. phase: cycles at the beginning.

    A wave with edges or corners is averaged over the sample period (a box filter). Components that
    alias to tactile frequencies lie near multiples of the sample rate, where that filter has its
    zeros.
    """

    duration: ClassVar[float] = math.inf
    has_edges: ClassVar[bool] = True

    frequency: float | Automation = parameter(60.0, "Hertz", 0.0, MAX_FREQUENCY, keyed=True)
    amplitude: float | Automation = parameter(1.0, "Largest value", -MAX_PEAK, MAX_PEAK, keyed=True)
    phase: float = parameter(0.0, "Initial phase in cycles, 0 to 1", -1e6, 1e6)

    def values(self, times: FloatArray, step: float) -> FloatArray:
        aliases = largest(self.frequency) * step >= 0.5
        if isinstance(self.frequency, Automation):
            width: float | FloatArray = (
                self.frequency.at(times) * step if self.has_edges or aliases else 0.0
            )
            cycles = self.frequency.integral(times)
        else:
            width = self.frequency * step
            cycles = self.frequency * times
        if self.phase:
            cycles += self.phase
        result = self.wave(cycles, width)
        if isinstance(self.amplitude, Automation) or self.amplitude != 1.0:
            result = result * values_of(self.amplitude, times)
        if aliases:
            result = np.where(np.less(width, 0.5), result, 0.0)
        return result

    @abstractmethod
    def wave(self, cycles: FloatArray, width: float | FloatArray) -> FloatArray:
        """Return the wave at phase `cycles`, averaged over `width` cycles around it if it has edges
        or corners."""


@frozen
class Sine(Oscillator, kind="sine"):
    """sin(2π cycles)."""

    has_edges: ClassVar[bool] = False

    def wave(self, cycles: FloatArray, width: float | FloatArray) -> FloatArray:
        return sine(cycles)


@frozen
class Square(Oscillator, kind="square"):
    """+1 in the first half of the period, -1 in the second."""

    def wave(self, cycles: FloatArray, width: float | FloatArray) -> FloatArray:
        to_edge = _distance(cycles - 0.25) - 0.25
        return np.clip(-2 * to_edge / np.maximum(width, 1e-9), -1.0, 1.0)


@frozen
class Triangle(Oscillator, kind="triangle"):
    """0, +1, 0, -1 at the quarters of the period, straight between them."""

    def wave(self, cycles: FloatArray, width: float | FloatArray) -> FloatArray:
        from_top = _distance(cycles - 0.25)
        width = np.maximum(width, 1e-9)
        top = np.maximum(width / 2 - from_top, 0.0)
        bottom = np.maximum(width / 2 - (0.5 - from_top), 0.0)
        return np.asarray(1.0 - 4 * from_top + 4 * (bottom * bottom - top * top) / width)


@frozen
class Saw(Oscillator, kind="saw"):
    """Rises from -1 to +1 over the period, then jumps back."""

    def wave(self, cycles: FloatArray, width: float | FloatArray) -> FloatArray:
        from_edge = cycles - np.round(cycles)
        return 2 * from_edge - np.clip(2 * from_edge / np.maximum(width, 1e-9), -1.0, 1.0)


@frozen
class Pulse(Oscillator, kind="pulse"):
    """A train of pulses: 1 for the first `duty` (0 to 1) of the period, 0 for the rest."""

    duty: float = parameter(0.1, "Part of the period for which a pulse is 1", 0.0, 1.0)

    def wave(self, cycles: FloatArray, width: float | FloatArray) -> FloatArray:
        half = self.duty / 2
        from_centre = _distance(cycles - half)
        width = np.maximum(width, 1e-6)
        low = from_centre - width / 2
        high = from_centre + width / 2
        this = np.maximum(np.minimum(high, half) - np.maximum(low, -half), 0.0)
        following = np.maximum(high - (1.0 - half), 0.0)
        return np.asarray(np.minimum((this + following) / width, 1.0))


def _distance(cycles: FloatArray) -> FloatArray:
    """Return the distance to the nearest whole number, from 0 to 0.5."""
    return np.abs(cycles - np.round(cycles))


def sine(cycles: FloatArray) -> FloatArray:
    """Return sin(2π cycles), shape (n,), with an absolute error below 1e-15, apart from the
    rounding of `cycles`.

    Uses only sums and products, so the result is bit-identical on every machine, and is twice as
    fast as the library's sine.
    """
    # sin(2π c) = sin(2π q) with q = |frac(c - 1/4) - 1/2| - 1/4, which is within ±1/4.
    quarter = cycles - 0.25
    quarter -= np.floor(quarter)
    quarter -= 0.5
    np.abs(quarter, out=quarter)
    quarter -= 0.25
    square = quarter * quarter
    result = square * _SINE_COEFFICIENTS[0]
    for coefficient in _SINE_COEFFICIENTS[1:-1]:
        result += coefficient
        result *= square
    result += _SINE_COEFFICIENTS[-1]
    result *= quarter
    return result
