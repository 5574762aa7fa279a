"""Steady tones on many paths at once: what takes no table of samples and no interpolation.

On a path whose delay goes in a straight line a tone stays a tone, of another frequency (Doppler). Cut into runs of samples, its value is
sin(a + b) = sin a cos b + cos a sin b, with a for the run and b for the place in the run; so a sum over voices is a matrix product of small
matrices. Powers of e^{iω} stand for sines: the error grows with the number of samples, about 1e-16 for each.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray


class TonePaths:
    """Tones of n_voices voices on their paths to n_listeners listeners, for `count` samples.

    start: phases in cycles at the first sample, shape (n_listeners, n_voices), or (1, n_voices) where all listeners get the same.
    step: cycles per sample, of the same shape. gain, gain_step: the gains at the first sample and their change per sample, shape
    (n_listeners, n_voices).
    """

    def __init__(self, start: FloatArray, step: FloatArray, gain: FloatArray, gain_step: FloatArray, count: int) -> None:
        self._count = count
        width = max(math.isqrt(count), 1)
        runs = -(-count // width)
        turn = _turn(step)
        fine = _powers(turn, width)
        coarse = _powers(fine[-1] * turn, runs)
        coarse *= _turn(start)
        # The gain is linear: gain of the run's first sample plus what it rises by within the run.
        first = gain[:, None] + gain_step[:, None] * (width * np.arange(runs))[:, None]
        sine, cosine = coarse.imag.transpose(1, 0, 2), coarse.real.transpose(1, 0, 2)
        listeners, voices = gain.shape
        # (listeners, runs or places in a run, terms, voices)
        self._runs = np.empty((listeners, runs, 4, voices))
        np.multiply(first, sine, out=self._runs[:, :, 0])
        np.multiply(first, cosine, out=self._runs[:, :, 1])
        np.multiply(gain_step[:, None], sine, out=self._runs[:, :, 2])
        np.multiply(gain_step[:, None], cosine, out=self._runs[:, :, 3])
        self._places = np.empty((len(start), width, 4, voices))
        self._places[:, :, 0], self._places[:, :, 1] = fine.real.transpose(1, 0, 2), fine.imag.transpose(1, 0, 2)
        np.multiply(self._places[:, :, :2], np.arange(width)[:, None, None], out=self._places[:, :, 2:])

    def summed(self) -> FloatArray:
        """Return the sum over voices, shape (n_listeners, count)."""
        listeners, runs, terms, voices = self._runs.shape
        alike, width = self._places.shape[:2]
        places = self._places.reshape(alike, width, terms * voices).transpose(0, 2, 1)
        sums = self._runs.reshape(listeners, runs, terms * voices) @ places
        return np.asarray(sums.reshape(listeners, runs * width)[:, : self._count])

    def at_listeners(self, chosen: list[int]) -> FloatArray:
        """Return the voices as they reach some listeners, shape (n_voices, n_chosen, count)."""
        _, runs, _, voices = self._runs.shape
        places = self._places if len(self._places) == 1 else self._places[chosen]
        each = self._runs[chosen].transpose(3, 0, 1, 2) @ places.transpose(3, 0, 2, 1)
        return each.reshape(voices, len(chosen), runs * self._places.shape[1])[:, :, : self._count]


def _turn(cycles: FloatArray) -> NDArray[np.complex128]:
    """Return e^{2πi cycles}."""
    angle = (2 * np.pi) * (cycles - np.floor(cycles))
    turn = np.empty(angle.shape, dtype=np.complex128)
    np.cos(angle, out=turn.real)
    np.sin(angle, out=turn.imag)
    return turn


def _powers(base: NDArray[np.complex128], count: int) -> NDArray[np.complex128]:
    """Return base^0 to base^(count - 1) in a new first axis, by doubling."""
    powers = np.empty((count, *base.shape), dtype=np.complex128)
    powers[0] = 1.0
    known, factor = 1, base
    while known < count:
        more = min(known, count - known)
        np.multiply(powers[:more], factor, out=powers[known : known + more])
        known += more
        factor = factor * factor
    return powers
