"""A look-ahead limiter."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from .mixing import saturated

LOOK_AHEAD = 0.005
"""Look-ahead of the limiter [s], which is its latency."""
HOLD = 0.025
"""Seconds for which the limiter keeps its gain after a peak: half a period of 20 Hz, so that a
steady tone is attenuated without distortion."""
RELEASE = 0.15
"""Time constant of the release [s], in which the gain rises by a factor e (8.7 dB)."""
_RUN = 4096


class Limiter:
    """A look-ahead limiter for several channels: no sample above `s_max`, a gain that changes
    smoothly, and no change at all below.

    The gain that each sample needs is held over the look-ahead and HOLD, released at 1/RELEASE
    nepers a second, and averaged over the look-ahead (a Hann window). Every value in the average is
    low enough for the sample, hence so is the average.

    s_max: shape (n_channels,), positive. Output lags input by `latency` samples.
    """

    def __init__(self, s_max: FloatArray, sample_rate: float) -> None:
        self.latency = max(round(LOOK_AHEAD * sample_rate), 1)
        self._s_max = np.asarray(s_max, dtype=np.float64)[:, None]
        self._window = self.latency + 1 + round(HOLD * sample_rate)
        self._rise = 1.0 / (RELEASE * sample_rate)
        kernel = np.hanning(self.latency + 3)[1:-1]
        self._kernel = kernel / kernel.sum()
        self.reset()

    def reset(self) -> None:
        """Drop all state."""
        channels = len(self._s_max)
        self._input = np.zeros((channels, self.latency))
        self._needed = np.ones((channels, self._window - 1))
        self._held = np.ones((channels, self.latency))

    def process(self, block: FloatArray) -> FloatArray:
        """Return the next samples out for the next samples in, both of shape (n_channels, n)."""
        pieces = [
            self._process(block[:, begin : begin + _RUN])
            for begin in range(0, block.shape[1], _RUN)
        ]
        return np.concatenate(pieces, axis=1) if pieces else block.copy()

    def _process(self, block: FloatArray) -> FloatArray:
        count = block.shape[1]
        delayed = np.concatenate((self._input, block), axis=1)
        self._input = delayed[:, count:]
        magnitude = np.abs(block)
        active = ~(magnitude <= self._s_max).all(axis=1)
        active |= (self._needed != 1.0).any(axis=1) | (self._held != 1.0).any(axis=1)
        limited = delayed[:, :count].copy()
        rows = active.nonzero()[0]
        if len(rows) == 0:
            return limited
        s_max = self._s_max[rows]
        needed = np.concatenate(
            (self._needed[rows], s_max / np.maximum(magnitude[rows], s_max)), axis=1
        )
        self._needed[rows] = needed[:, count:]
        before = self._held[rows]
        released = self._released(_sliding_minimum(needed, self._window), before[:, -1:])
        held = np.concatenate((before, released), axis=1)
        self._held[rows] = held[:, count:]
        gain = np.stack([np.correlate(row, self._kernel, "valid") for row in held])
        # A window of ones sums to 1 up to rounding, and must change nothing.
        gain[np.abs(gain - 1.0) < 1e-12] = 1.0
        limited[rows] = saturated(limited[rows] * gain, s_max)
        return limited

    def _released(self, gain: FloatArray, before: FloatArray) -> FloatArray:
        """Return the minimum of the gain and of all earlier gains after their exponential release,
        at most 1."""
        age = np.arange(1, gain.shape[1] + 1) * self._rise
        lowest = np.minimum.accumulate(
            np.concatenate((before, gain * np.exp(-age)), axis=1), axis=1
        )[:, 1:]
        return np.asarray(np.minimum(lowest * np.exp(age), 1.0))


def _sliding_minimum(values: FloatArray, width: int) -> FloatArray:
    """Return the minimum over each run of `width` columns, by doubling the width."""
    span = 1
    while 2 * span <= width:
        values = np.minimum(values[:, span:], values[:, :-span])
        span *= 2
    rest = width - span
    return np.minimum(values[:, rest:], values[:, :-rest]) if rest else values
