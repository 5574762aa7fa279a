"""Steady tones on many paths at once, without a table of samples or interpolation.

On a path whose delay changes linearly a tone stays a tone, of another frequency (Doppler). Cut into
runs of samples, its value is sin(a + b) = sin a cos b + cos a sin b, with a for the run and b for
the place in the run; so a sum over voices is a product of small matrices. Powers of e^{iω} stand
for sines: the error grows with the number of samples, about 1e-16 for each.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray


class TonePaths:
    """Tones of n_voices voices on their paths to n_listeners listeners, for `count` samples.

    Args:
        start: phases in cycles at the first sample, shape (n_listeners, n_voices), or (1, n_voices)
            where all listeners get the same.
        step: cycles per sample, of the same shape.
        factors: of the gains, which are sums of products, shape (n_terms, n_listeners, n_voices).
        curves: per term, for the first m <= count samples, shape (m,); the first is 1 throughout.
        count: number of samples.
    """

    def __init__(
        self,
        start: FloatArray,
        step: FloatArray,
        factors: FloatArray,
        curves: Sequence[FloatArray],
        count: int,
    ) -> None:
        self._count = count
        self._curves = curves
        width = max(math.isqrt(count), 1)
        turn = _turn(step)
        fine = _powers(turn, width)
        coarse = _powers(fine[-1] * turn, -(-count // width))
        coarse *= _turn(start)
        sine = coarse.imag.transpose(1, 0, 2)
        cosine = coarse.real.transpose(1, 0, 2)
        # Per term: (listeners, runs, sine and cosine, voices).
        self._runs = []
        for factor, curve in zip(factors[:, :, None], curves, strict=True):
            needed = -(-len(curve) // width)
            runs = np.empty((len(factor), needed, 2, factor.shape[2]))
            np.multiply(factor, sine[:, :needed], out=runs[:, :, 0])
            np.multiply(factor, cosine[:, :needed], out=runs[:, :, 1])
            self._runs.append(runs)
        self._places = np.empty((len(start), width, 2, start.shape[1]))
        self._places[:, :, 0] = fine.real.transpose(1, 0, 2)
        self._places[:, :, 1] = fine.imag.transpose(1, 0, 2)

    def summed(self) -> FloatArray:
        """Return the sum over voices, shape (n_listeners, count)."""
        listeners = len(self._runs[0])
        alike, width, _, voices = self._places.shape
        places = self._places.reshape(alike, width, 2 * voices)
        sums = [
            np.einsum("arv,awv->arw", runs.reshape(alike, -1, 2 * voices), places).reshape(
                listeners, -1
            )
            for runs in self._runs
        ]
        total: FloatArray = sums[0][:, : self._count]
        for some, curve in zip(sums[1:], self._curves[1:], strict=True):
            total[:, : len(curve)] += some[:, : len(curve)] * curve
        return total

    def at_listeners(self, chosen: list[int]) -> FloatArray:
        """Return the voices as they reach some listeners, shape (n_voices, n_chosen, count)."""
        places = (self._places if len(self._places) == 1 else self._places[chosen]).transpose(
            3, 0, 2, 1
        )
        each = [
            (runs[chosen].transpose(3, 0, 1, 2) @ places).reshape(len(places), len(chosen), -1)
            for runs in self._runs
        ]
        total: FloatArray = each[0][:, :, : self._count]
        for some, curve in zip(each[1:], self._curves[1:], strict=True):
            total[:, :, : len(curve)] += some[:, :, : len(curve)] * curve
        return total


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
