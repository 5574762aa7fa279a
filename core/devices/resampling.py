"""Streaming sample rate conversion with a low delay, for devices that are driven by samples.

A linear-phase low-pass of this quality would lag by 14 samples of the lower rate, 14 ms at 1 kHz.
This one is a least-squares fit of a plain delay of `DELAY` samples up to 0.8 times the lower
Nyquist frequency and of silence from 1.2 times on, to within -86 dB; between the two only its
magnitude is bounded (it reaches +4 dB). Frequencies above the lower Nyquist frequency therefore
alias only to those above 0.8 times it. The fit is a sum of B-splines, so it can be evaluated at any
ratio of the rates.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ..arrays import FloatArray

DELAY = 7.8
"""Delay in samples of the lower of the two rates."""

_LENGTH = 40
"""Length of the impulse response, in the same samples."""
_PASS, _STOP, _HIGHEST = 0.4, 0.6, 5.0
"""Ends of the pass band and of the fitted stop band, in cycles per sample of the lower rate."""
_DEGREE, _PER_SAMPLE = 7, 4
"""Degree of the B-splines, and their number per sample of the lower rate."""
_BETWEEN = 1.5e-8
"""Weight of the squared response between the bands."""


class Resampler:
    """Changes the sample rate of some channels block by block.

    The output does not depend on the division of the input into blocks. It lags by ``delay``
    seconds.
    """

    def __init__(self, channels: int, rate_in: int, rate_out: int) -> None:
        """Rates: samples per second, above 0; raises ValueError otherwise."""
        if rate_in <= 0 or rate_out <= 0:
            raise ValueError(f"rate {min(rate_in, rate_out)} is not above 0")
        common = math.gcd(rate_in, rate_out)
        self._up = rate_out // common
        self._down = rate_in // common
        self._same = rate_in == rate_out
        self.delay = 0.0 if self._same else DELAY / min(rate_in, rate_out)
        self._taps = (
            np.ones((1, 1)) if self._same else _phases(self._up, min(1.0, rate_out / rate_in))
        )
        self._channels = channels
        self.reset()

    def reset(self) -> None:
        """Reset to silence."""
        self._history = np.zeros((self._channels, self._taps.shape[1] - 1))
        # Position of the next output sample after the start of the history, in steps of 1 / up of
        # an input sample.
        self._position = 0

    def process(self, block: FloatArray) -> FloatArray:
        """Return the next output samples, shape (channels, m), for the next input samples, shape
        (channels, n), n >= 0."""
        if self._same:
            return block
        samples = np.concatenate([self._history, block], axis=1)
        width = self._taps.shape[1]
        available = max(samples.shape[1] - width + 1, 0)
        count = max(-(-(available * self._up - self._position) // self._down), 0)
        places = self._position + self._down * np.arange(count)
        start = places // self._up
        phase = places % self._up
        windows = np.lib.stride_tricks.as_strided(
            samples, (self._channels, available, width), (*samples.strides, samples.itemsize)
        )[:, start]
        output: FloatArray = np.einsum("cmw,mw->cm", windows, self._taps[phase])
        kept = min(available, (self._position + self._down * count) // self._up)
        self._history = samples[:, kept:]
        self._position += self._down * count - self._up * kept
        return output


def _phases(up: int, lower: float) -> FloatArray:
    """Return the weights of input samples, the oldest first, one row for each of ``up`` positions
    between two of them; each row sums to 1.

    lower: the lower of the two rates by the input's.
    """
    width = math.ceil(_LENGTH / lower) + 1
    ages = np.arange(width - 1, -1, -1) + np.arange(up)[:, None] / up
    taps = _impulse_response(ages * lower)
    return np.asarray(taps / taps.sum(axis=1, keepdims=True))


def _impulse_response(times: FloatArray) -> FloatArray:
    """Return the low-pass's impulse response at ``times`` (any shape) in samples of the lower
    rate."""
    coefficients = np.concatenate([_coefficients(), np.zeros(_DEGREE + 1)])
    position = np.clip(times * _PER_SAMPLE, 0.0, len(coefficients) - 1e-9)
    last = position.astype(np.intp)
    response = np.zeros(times.shape)
    for back in range(_DEGREE + 1):
        number = last - back  # a spline that begins at its number
        response += np.where(number >= 0, coefficients[number], 0.0) * _spline(position - number)
    return response


def _spline(at: FloatArray) -> FloatArray:
    """Return the B-spline with integer knots from 0 to `_DEGREE` + 1 at positions between them."""
    terms = (
        (-1) ** knot * math.comb(_DEGREE + 1, knot) * np.maximum(at - knot, 0.0) ** _DEGREE
        for knot in range(_DEGREE + 1)
    )
    return np.asarray(sum(terms) / math.factorial(_DEGREE))


@lru_cache(maxsize=1)
def _coefficients() -> FloatArray:
    """Return the weights of the B-splines, the first of which begins at time 0."""
    centre = (np.arange(_LENGTH * _PER_SAMPLE - _DEGREE) + (_DEGREE + 1) / 2) / _PER_SAMPLE
    # Chebyshev nodes in either band: with them the least-squares fit is close to the minimax one.
    passed = _PASS * np.sin(np.pi / 2 * np.arange(120) / 119)
    stopped = (
        _STOP + (_HIGHEST - _STOP) * (1.0 - np.cos(np.pi * (np.arange(400) + 0.5) / 400)) / 2.0
    )
    between = np.linspace(_PASS, _STOP, 25)
    frequency = np.concatenate([passed, stopped, between])
    weight = np.sqrt(np.concatenate([np.ones(120), stopped / _STOP, np.full(25, _BETWEEN)]))
    weight[0] = 1000.0  # a steady value passes as it is
    spectrum = weight * np.sinc(frequency / _PER_SAMPLE) ** (_DEGREE + 1)
    angle = 2.0 * np.pi * frequency[:, None] * (centre - DELAY)
    matrix = np.concatenate([spectrum[:, None] * np.cos(angle), spectrum[:, None] * np.sin(angle)])
    wanted = np.zeros(len(matrix))
    wanted[:120] = weight[:120]
    return np.linalg.solve(matrix.T @ matrix, matrix.T @ wanted)
