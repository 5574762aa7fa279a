"""Removal of the steady part of samples: a push that nobody feels, heats a coil, and takes travel
from the vibration."""

from __future__ import annotations

import math

import numpy as np

from ..arrays import FloatArray

CUTOFF = 1.0
"""Hertz, a fifth of the lowest frequency that is felt: a tone of 5 Hz loses 0.17 dB, one of 20 Hz
0.01 dB."""


class HighPass:
    """A filter of first order for some channels, block by block: ``y = x - l`` with ``l[n] = a
    l[n-1] + (1 - a) x[n]``.

    The output does not depend on the division of the input into blocks, but for rounding.
    """

    def __init__(self, channels: int, rate: float) -> None:
        """rate: samples per second."""
        self._channels, self._rate = channels, rate
        self._decay = math.exp(-2 * math.pi * CUTOFF / rate)
        self.reset()

    def reset(self) -> None:
        """Forget the samples so far."""
        self._steady = np.zeros((self._channels, 1))

    def process(self, block: FloatArray) -> FloatArray:
        """The block (channels, n) without its steady part."""
        longest = math.ceil(self._rate)  # in a second the powers below stay within a factor of 535
        return np.concatenate(
            [self._piece(block[:, k : k + longest]) for k in range(0, block.shape[1], longest)]
            or [block],
            axis=1,
        )

    def _piece(self, samples: FloatArray) -> FloatArray:
        # l[n] = a^(n+1) (l[-1] + (1 - a) sum of a^-(m+1) x[m] for m up to n)
        powers = self._decay ** np.arange(1, samples.shape[1] + 1)
        steady = powers * (self._steady + (1 - self._decay) * np.cumsum(samples / powers, axis=1))
        self._steady = steady[:, -1:]
        return samples - steady
