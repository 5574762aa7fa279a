"""Waveforms of listeners over many frames for drawing at any zoom: samples, and a pyramid of their
minima and maxima."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import BoolArray, FloatArray
from ..perception import sensation_level

FULL_SCALE = 32767
"""Integer value of the sample 1.0: steps of 1/32767 are 90 dB below full scale, far below the
threshold of feeling."""
WINDOW_SECONDS = 0.25
"""Duration over which the threshold of feeling is computed [s]."""
_STEP = 8  # values of a level that one of the next coarser level stands for


def as_integers(samples: FloatArray) -> NDArray[np.int16]:
    """Samples in [-1, 1] as integers."""
    return np.rint(np.clip(samples, -1, 1) * FULL_SCALE).astype(np.int16)


@dataclass(frozen=True, slots=True)
class Columns:
    """Parts of a wave, from left to right: the range of the samples in each, ``low`` and ``high``
    (l, c) as integers, ``threshold`` (l, c) the peak of this vibration at the threshold of feeling
    [dB of full scale], NaN for silence; ``known`` (c,): whether there are samples."""

    low: NDArray[np.int16]
    high: NDArray[np.int16]
    threshold: FloatArray
    known: BoolArray


class Waves:
    """``samples`` (l, n), n > 0, of ``listeners``, the first at the frame ``origin``, ``per_frame``
    of them a frame.

    ``impacts``: the frames (m,) at which they began, and the gains (m, l) with which each listener
    felt them. One thread writes; another that reads at the same time may miss the data being
    written.
    """

    def __init__(
        self,
        listeners: Sequence[str],
        origin: float,
        per_frame: float,
        samples: NDArray[np.int16],
        filled: bool,
    ) -> None:
        self.listeners = tuple(listeners)
        self.origin, self.per_frame = origin, per_frame
        count, length = samples.shape
        self.filled: BoolArray = np.full(math.ceil(length / per_frame - 1e-9), filled)
        self.threshold: FloatArray = np.full((count, len(self.filled)), np.nan, dtype=np.float32)
        self.impacts: tuple[FloatArray, FloatArray] = np.zeros(0), np.zeros((0, count))
        self._low, self._high = [samples], [samples]
        while self._low[-1].shape[1] > _STEP:
            shape = count, math.ceil(self._low[-1].shape[1] / _STEP)
            self._low.append(np.zeros(shape, dtype=np.int16))
            self._high.append(np.zeros(shape, dtype=np.int16))
        if filled:
            self._condense(0, length)

    @property
    def end(self) -> float:
        """The frame at which the samples end."""
        return self.origin + len(self.filled)

    def find_thresholds(self, sample_rate: float) -> None:
        """Compute the threshold of feeling from the samples, window after window."""
        samples, width = self._low[0], round(WINDOW_SECONDS * sample_rate)
        for begin in range(0, samples.shape[1], width):
            part = samples[:, begin : begin + width] / FULL_SCALE
            frames = slice(
                round(begin / self.per_frame), math.ceil((begin + width) / self.per_frame)
            )
            self.threshold[:, frames] = threshold_of(part, sample_rate)[:, None]

    def write(self, start: int, block: FloatArray, threshold: FloatArray) -> None:
        """Keep the samples (l, n) of a frame, the first is number ``start``, and its threshold
        (l,), replacing earlier ones; samples outside are dropped."""
        first, last = max(start, 0), min(start + block.shape[1], self._low[0].shape[1])
        if first >= last:
            return
        frames = slice(
            round(first / self.per_frame),
            max(round(last / self.per_frame), round(first / self.per_frame) + 1),
        )
        self._low[0][:, first:last] = as_integers(block[:, first - start : last - start])
        self._condense(first, last)
        began, gain = self.impacts
        others = (began < self.origin + frames.start) | (began >= self.origin + frames.stop)
        self.impacts = began[others], gain[others]
        self.threshold[:, frames] = threshold[:, None]
        self.filled[frames] = True

    def add_impacts(self, frame: FloatArray, gain: FloatArray) -> None:
        """Add impacts at frames (m,), felt with gains (m, l)."""
        self.impacts = (
            np.concatenate([self.impacts[0], frame]),
            np.concatenate([self.impacts[1], gain]),
        )

    def columns(self, edges: FloatArray) -> Columns:
        """The parts between ``edges`` (c + 1,), frames that rise evenly."""
        place = (edges - self.origin) * self.per_frame
        step = (place[-1] - place[0]) / (len(place) - 1)
        level = min(max(math.floor(math.log(max(step, 1.0), _STEP)), 0), len(self._low) - 1)
        at = np.clip(np.floor(place / _STEP**level), 0, self._low[level].shape[1] - 1).astype(
            np.int64
        )
        shown, starts = slice(at[0], at[-1] + 1), at[:-1] - at[0]
        begun, count = np.concatenate([[0], np.cumsum(self.filled)]), len(self.filled)
        left, right = (
            np.clip(to(edges - self.origin), 0, count).astype(np.int64)
            for to in (np.floor, np.ceil)
        )
        return Columns(
            np.minimum.reduceat(self._low[level][:, shown], starts, axis=1),
            np.maximum.reduceat(self._high[level][:, shown], starts, axis=1),
            self.threshold[:, np.minimum(left[:-1], count - 1)],
            begun[right[1:]] > begun[left[:-1]],
        )

    def _condense(self, first: int, last: int) -> None:
        """Compute the minima and maxima that the samples ``first`` to ``last`` - 1 are part of."""
        for level in range(1, len(self._low)):
            first, last = first // _STEP, math.ceil(last / _STEP)
            below = slice(_STEP * first, _STEP * last)
            for way, of in ((np.minimum, self._low), (np.maximum, self._high)):
                part = of[level - 1][:, below]
                of[level][:, first:last] = way.reduceat(
                    part, np.arange(0, part.shape[1], _STEP), axis=1
                )


def threshold_of(samples: FloatArray, sample_rate: float) -> FloatArray:
    """The peak (l,) of ``samples`` (l, n) scaled to the threshold of feeling [dB of full scale];
    NaN for silence."""
    with np.errstate(divide="ignore", invalid="ignore"):
        level = 20 * np.log10(np.abs(samples).max(axis=1, initial=0.0)) - sensation_level(
            samples, sample_rate
        )
    return np.where(np.isfinite(level), level, np.nan)
