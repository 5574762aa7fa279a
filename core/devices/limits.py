"""Limits of a device's drive: a ceiling, a slew rate, and a limit on sustained power."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from ..arrays import FloatArray


class DriveLimits:
    """The limits of one device's channels, with the state of the previous drive.

    ceilings: (channels,) largest amplitudes, in (0, 1]. slew: largest rise per second; falling is
    not limited. sustained_maximum, sustained_seconds: the running mean square of each channel with
    this time constant stays at or below the square of the maximum. With 0.7 and 10 s, full
    amplitude lasts 6.7 s and then falls to 0.7. interval: duration of a command [s]; each is
    limited as if it lasted that long.
    """

    def __init__(
        self,
        ceilings: FloatArray,
        slew: float,
        sustained_maximum: float,
        sustained_seconds: float,
        interval: float,
    ) -> None:
        self._ceilings: list[float] = ceilings.tolist()
        self._slew = slew
        self._interval = interval
        self._square = sustained_maximum**2
        self._seconds = sustained_seconds
        self._share = -math.expm1(-interval / sustained_seconds)
        self._scale = 1.0
        self._mean_square = [0.0] * len(ceilings)
        self._driven = [0.0] * len(ceilings)

    def scale_ceilings(self, scale: float) -> None:
        """Lower all ceilings by this factor in [0, 1], from the next call on."""
        self._scale = scale

    def limited(self, wanted: FloatArray, elapsed: float) -> FloatArray:
        """The permitted drive. wanted: (channels,) in [0, 1]; elapsed: seconds since the last call,
        0 or more."""
        # One by one: devices have few channels, and arrays of two numbers cost more than two
        # numbers.
        past = -math.expm1(-elapsed / self._seconds)
        rise = self._slew * min(elapsed, self._interval)
        for k, (value, ceiling, driven, mean_square) in enumerate(
            zip(wanted.tolist(), self._ceilings, self._driven, self._mean_square, strict=True)
        ):
            mean_square += (driven * driven - mean_square) * past
            sustainable = math.sqrt(
                max(mean_square + (self._square - mean_square) / self._share, 0.0)
            )
            self._mean_square[k] = mean_square
            self._driven[k] = min(value, self._scale * ceiling, driven + rise, sustainable)
        return np.array(self._driven)


class SampleLimits:
    """The limits of channels that are driven by samples: samples whose peaks exceed the limits are
    attenuated."""

    def __init__(self, limits: DriveLimits, channels: int) -> None:
        self._limits = limits
        self._gains = np.ones((channels, 1))

    def limited(self, samples: FloatArray, seconds: float) -> FloatArray:
        """Samples (channels, n) that last ``seconds``, scaled so that their peaks are within the
        limits; the scale rises smoothly."""
        peaks = np.abs(samples).max(axis=1, initial=0.0)
        allowed = self._limits.limited(np.minimum(peaks, 1.0), seconds)
        gains = np.array(
            [
                [gain / peak if peak > 0.0 else 1.0]
                for gain, peak in zip(allowed.tolist(), peaks.tolist(), strict=True)
            ]
        )
        ramp = _ramp(samples.shape[1])
        start = np.minimum(self._gains, gains)
        self._gains = gains
        return np.asarray(samples * (start + (gains - start) * ramp))


@cache
def _ramp(count: int) -> FloatArray:
    """``count`` values from 0 to 1, evenly spaced. Shared and read-only."""
    return np.linspace(0.0, 1.0, count)
