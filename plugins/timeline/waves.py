"""Waveforms and levels of listeners over many frames for drawing at any zoom: samples, a pyramid of
their minima and maxima, and the level at the end of each frame."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import BoolArray, FloatArray, IntArray
from ...core.frozen import frozen
from ...core.render.integers import FULL_SCALE, as_integers
from ...core.render.lane import FilledBand, height_of, highest, levels_over_time
from ...core.scene.values import Listener

_STEP = 8  # values of a level that one of the next coarser level stands for


@frozen
class Columns:
    """Parts of a wave, from left to right: the range of the samples in each, ``low`` and ``high``
    (l, c) as integers; ``level`` (l, c) the highest [dB of full scale]; ``threshold`` (l, c) the
    level of this vibration at the threshold of feeling, NaN for silence; ``known`` (c,): whether
    there are samples."""

    low: NDArray[np.int16]
    high: NDArray[np.int16]
    level: FloatArray
    threshold: FloatArray
    known: BoolArray


class Waves:
    """Samples of listeners over many frames. One thread writes; another that reads at the same time
    may miss the data being written.

    Args:
        listeners: their names.
        origin: the frame at which the samples begin.
        per_frame: samples in a frame.
        samples: (l, n), n > 0.
        filled: whether they are known already.

    Attributes:
        level, threshold: (l, f) those of the last `LEVEL_SECONDS` up to the end of each frame, as
            the meters show them.
        sources: the amplitudes (f,) by name [dB].
        impacts: the frames (m,) at which they began, and the gains (m, l) with which each listener
            felt them.
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
        self.level: FloatArray = np.full_like(self.threshold, -np.inf)
        self.sources: dict[str, FloatArray] = {}
        self.impacts: tuple[FloatArray, FloatArray] = np.zeros(0), np.zeros((0, count))
        self._low = [samples]
        self._high = [samples]
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

    def find_levels(self, sample_rate: float, listeners: Sequence[Listener] = ()) -> None:
        """Set levels and thresholds from the samples."""
        self.level, self.threshold = levels_over_time(
            self._low[0] / FULL_SCALE, sample_rate, self.per_frame, listeners
        )

    def write(
        self,
        start: int,
        block: FloatArray,
        level: FloatArray,
        threshold: FloatArray,
        sources: Mapping[str, float] = MappingProxyType({}),
    ) -> None:
        """Keep the samples, level and threshold of a frame, and the amplitudes of its sources, in
        place of earlier ones. Samples that lie outside the range of the waves are dropped.

        Args:
            start: number of the first sample.
            block: the samples (l, n).
            level: (l,) [dB of full scale].
            threshold: level of this vibration at the threshold of feeling (l,) [dB].
            sources: amplitudes by name.
        """
        first = max(start, 0)
        last = min(start + block.shape[1], self._low[0].shape[1])
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
        self.level[:, frames] = level[:, None]
        self.threshold[:, frames] = threshold[:, None]
        self.write_sources(frames, sources)
        self.filled[frames] = True

    def write_sources(self, frames: slice, amplitudes: Mapping[str, float]) -> None:
        """Keep the amplitudes of the sources that sound in some frames, instead of earlier ones."""
        for row in self.sources.values():
            row[frames] = -np.inf
        for name in amplitudes.keys() - {""}:
            row = self.sources.setdefault(name, np.full(len(self.filled), -np.inf))
            row[frames] = 20 * math.log10(max(amplitudes[name], 1e-9))

    def add_impacts(self, frame: FloatArray, gain: FloatArray) -> None:
        """Add impacts at frames (m,), felt with gains (m, l)."""
        self.impacts = (
            np.concatenate([self.impacts[0], frame]),
            np.concatenate([self.impacts[1], gain]),
        )

    def columns(self, edges: FloatArray) -> Columns:
        """What is drawn in each of c columns; ``edges`` (c + 1,): evenly spaced frames between
        which they lie."""
        place = (edges - self.origin) * self.per_frame
        step = (place[-1] - place[0]) / (len(place) - 1)
        level = min(max(math.floor(math.log(max(step, 1.0), _STEP)), 0), len(self._low) - 1)
        at = np.clip(np.floor(place / _STEP**level), 0, self._low[level].shape[1] - 1).astype(
            np.int64
        )
        shown = slice(at[0], at[-1] + 1)
        starts = at[:-1] - at[0]
        begun = np.concatenate([[0], np.cumsum(self.filled)])
        left, right = self._frames(edges)
        return Columns(
            np.minimum.reduceat(self._low[level][:, shown], starts, axis=1),
            np.maximum.reduceat(self._high[level][:, shown], starts, axis=1),
            self.highest(self.level, edges),
            self.threshold[:, np.minimum(left[:-1], len(self.filled) - 1)],
            begun[right[1:]] > begun[left[:-1]],
        )

    def highest(self, values: FloatArray, edges: FloatArray) -> FloatArray:
        """The highest of values (r, f) of frames in each part between ``edges`` (c + 1,)."""
        return highest(values, edges - self.origin)

    def _frames(self, edges: FloatArray) -> tuple[IntArray, IntArray]:
        """Numbers of the frames that contain each of the ``edges`` (n,), and of the first frames
        that begin at or after each; clipped to the frames that exist."""
        left, right = (
            np.clip(to(edges - self.origin), 0, len(self.filled)).astype(np.int64)
            for to in (np.floor, np.ceil)
        )
        return left, right

    def _condense(self, first: int, last: int) -> None:
        """Compute the minima and maxima that the samples ``first`` to ``last`` - 1 are part of."""
        for level in range(1, len(self._low)):
            first = first // _STEP
            last = math.ceil(last / _STEP)
            below = slice(_STEP * first, _STEP * last)
            for way, of in ((np.minimum, self._low), (np.maximum, self._high)):
                part = of[level - 1][:, below]
                of[level][:, first:last] = way.reduceat(
                    part, np.arange(0, part.shape[1], _STEP), axis=1
                )


def row_name(name: str, second_object: str | None, onset: float) -> str:
    """The row that shows a source: its own name, also where it sounds at each trigger from
    ``onset`` [s] on; "" for an impact, which has none."""
    return "" if second_object else name.removesuffix(f" at {onset:.4f} s")


def wave_band(parts: Columns) -> FilledBand:
    """Samples in decibels around the middle of a row: one line, however steep."""
    low, high = (_wave_heights().take(part.view(np.uint16)) for part in (parts.low, parts.high))
    low[:, 1:], high[:, 1:] = (
        np.minimum(low[:, 1:], high[:, :-1]),
        np.maximum(high[:, 1:], low[:, :-1]),
    )
    return FilledBand("wave", low, high)


@cache
def _wave_heights() -> FloatArray:
    """The height in a row for every 16-bit sample value."""
    values = np.arange(1 << 16, dtype=np.uint16).view(np.int16).astype(np.float64) / FULL_SCALE
    with np.errstate(divide="ignore"):
        return 0.5 + np.sign(values) * height_of(20 * np.log10(np.abs(values))) / 2
