"""Counter-based noise, which is the same on every machine and in every block."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..frozen import frozen
from .automation import Automation, parameter, values_of
from .base import Amplified
from .limits import MAX_PEAK


@frozen
class Noise(Amplified, kind="noise"):
    """Random values, uniform within ±amplitude, `rate` of them a second, straight lines between
    them.

    seed: 0 to 2^64 - 1. Value k is output k of the SplitMix64 generator (Steele, Lea, Flood 2014)
    of that seed, which can be computed without its predecessors. rate: new values a second, 1 to
    48,000; a low rate gives a rumble.
    """

    duration: ClassVar[float] = math.inf

    amplitude: float | Automation = parameter(1.0, "Largest value", -MAX_PEAK, MAX_PEAK, keyed=True)
    seed: int = parameter(0, "Seed of the noise", 0, 2**64 - 1, whole=True)
    rate: float = parameter(8000.0, "Values of noise per second", 1.0, 48_000.0)

    def values(self, times: FloatArray, step: float) -> FloatArray:
        position = times * self.rate
        whole = np.floor(position)
        share = position - whole
        first, last = (int(whole.min()), int(whole.max())) if len(whole) else (0, 0)
        if last - first <= 2 * len(whole):
            # Dense times share random values, so each value is drawn only once.
            drawn = _uniform(splitmix64(self.seed, np.arange(first, last + 2, dtype=np.uint64)))
            place = (whole - first).astype(np.intp)
            lower = drawn[place]
            upper = drawn[1:][place]
        else:
            index = whole.astype(np.uint64)
            lower = _uniform(splitmix64(self.seed, index))
            upper = _uniform(splitmix64(self.seed, index + np.uint64(1)))
        upper *= share
        np.subtract(1.0, share, out=share)
        lower *= share
        lower += upper
        amplitude = values_of(self.amplitude, times)
        return lower if isinstance(amplitude, float) and amplitude == 1.0 else lower * amplitude


def splitmix64(seed: int, index: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Return output number `index` (from 0) of SplitMix64 started with `seed`."""
    mixed = (index + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    mixed += np.uint64(seed)
    mixed ^= mixed >> np.uint64(30)
    mixed *= np.uint64(0xBF58476D1CE4E5B9)
    mixed ^= mixed >> np.uint64(27)
    mixed *= np.uint64(0x94D049BB133111EB)
    mixed ^= mixed >> np.uint64(31)
    return mixed


def _uniform(bits: NDArray[np.uint64]) -> FloatArray:
    """Return the upper 53 bits as a number in [-1, 1)."""
    numbers = (bits >> np.uint64(11)).astype(np.float64)
    numbers *= 2.0**-52
    numbers -= 1.0
    return numbers
