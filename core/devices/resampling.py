"""Streaming change of sample rate by a windowed sinc: what a device that takes samples at its own rate needs."""

from __future__ import annotations

import math

import numpy as np

from ..arrays import FloatArray

# Zero crossings of the sinc on either side, and Kaiser's window: about 60 dB of stop band, pass band up to 0.8 of the lower Nyquist rate.
_CROSSINGS = 16
_BETA = 6.0
_CUTOFF = 0.9


class Resampler:
    """Samples of some channels at one rate, taken block by block, given back at another.

    The output does not depend on how the input is cut into blocks. It lags by ``delay`` seconds.
    """

    def __init__(self, channels: int, rate_in: int, rate_out: int) -> None:
        """Rates: samples per second, above 0; raises ValueError otherwise."""
        if rate_in <= 0 or rate_out <= 0:
            raise ValueError(f"rate {min(rate_in, rate_out)} is not above 0")
        common = math.gcd(rate_in, rate_out)
        self._up, self._down = rate_out // common, rate_in // common
        self._same = rate_in == rate_out
        half = 0 if self._same else math.ceil(_CROSSINGS * max(1.0, rate_in / rate_out))
        self.delay = half / rate_in
        self._taps = _phases(self._up, half, _CUTOFF * min(1.0, rate_out / rate_in))
        self._channels = channels
        self.reset()

    def reset(self) -> None:
        """Forget the samples so far: as if silence had come before."""
        self._history = np.zeros((self._channels, self._taps.shape[1] - 1))
        # Where the next output sample lies after the start of the history, in steps of 1 / up of an input sample.
        self._position = 0

    def process(self, block: FloatArray) -> FloatArray:
        """The next output samples. block: (channels, n), n >= 0 -> (channels, m)."""
        if self._same:
            return block
        samples = np.concatenate([self._history, block], axis=1)
        width = self._taps.shape[1]
        available = max(samples.shape[1] - width + 1, 0)
        count = max(-(-(available * self._up - self._position) // self._down), 0)
        places = self._position + self._down * np.arange(count)
        start, phase = places // self._up, places % self._up
        windows = samples[:, start[:, None] + np.arange(width)]
        output: FloatArray = np.einsum("cmw,mw->cm", windows, self._taps[phase])
        kept = min(available, (self._position + self._down * count) // self._up)
        self._history = samples[:, kept:]
        self._position += self._down * count - self._up * kept
        return output


def _phases(up: int, half: int, cutoff: float) -> FloatArray:
    """One row of taps per phase, each summing to 1. cutoff: share of the input's Nyquist rate."""
    offsets = np.arange(2 * half + 1)[None, :] - half - np.arange(up)[:, None] / up
    shape = np.sqrt(np.maximum(0.0, 1.0 - (offsets / (half + 1.0)) ** 2))
    taps = np.sinc(cutoff * offsets) * np.i0(_BETA * shape)
    rows: FloatArray = taps / taps.sum(axis=1, keepdims=True)
    return rows
