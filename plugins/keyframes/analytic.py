"""Analytic signals of frequency bands, computed window by window."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import FloatArray, IntArray
from ...core.formats.tracks.listener_tracks import Row
from ...core.frozen import frozen

ComplexArray = NDArray[np.complex128]

WINDOW = 64
"""Length of a window (seconds, even)."""
CONTEXT = 2
"""Length of the signal before and after each window that is returned with it (seconds): a whole
number of points of every grid."""
_GUARD = 2
"""Further margin, in which the circular convolution of the transform wraps around (seconds)."""


@frozen
class Band:
    """A part of the spectrum from ``low`` to ``high`` hertz.

    Its weight fades over ``low_fade`` and ``high_fade`` hertz on either side of its edges. Keys lie
    on a grid of ``grid_rate`` hertz, at least twice the width with both fades.
    """

    low: float
    high: float
    low_fade: float
    high_fade: float
    grid_rate: float

    @property
    def centre(self) -> float:
        """The frequency (hertz) that the analytic signal is shifted down by; an integer, so that
        blocks have whole cycles."""
        return float(round((self.low - self.low_fade + self.high + self.high_fade) / 2))


@frozen(eq=False)
class Window:
    """Complex amplitudes of all bands in one window.

    start, end: seconds. parts: for each band its amplitude z on its grid, from ``origin`` seconds
    to at most ``CONTEXT`` seconds after the end of the window; the band is ``Re(z exp(2πi centre
    t))``. is_last: the window reaches the end of the signal.
    """

    start: int
    end: int
    origin: int
    parts: tuple[ComplexArray, ...]
    is_last: bool


def analytic_windows(row: Row, bands: Sequence[Band]) -> Iterator[Window]:
    """The windows of a signal in the order of time, at least one."""
    duration = row.count / row.sample_rate
    rate = row.sample_rate
    length = min(WINDOW, 2 * max(math.ceil(duration / 2), 1))
    margin = CONTEXT + _GUARD
    transformed = length + 2 * margin
    weights = [_weights(band, transformed, rate) for band in bands]
    for start in range(0, max(math.ceil(duration), 1), length):
        is_last = start + length >= duration
        spectrum = np.fft.rfft(row.read((start - margin) * rate, (start + length + margin) * rate))
        parts = [np.zeros(0, dtype=np.complex128)] * len(bands)
        # Bands with the same grid are transformed at once, because each call computes the factors
        # of the transform anew.
        for grid_rate in {band.grid_rate for band in bands}:
            numbers = [k for k, band in enumerate(bands) if band.grid_rate == grid_rate]
            count = round(transformed * grid_rate)
            shifted = np.zeros((len(numbers), count), dtype=np.complex128)
            for line, k in zip(shifted, numbers, strict=True):
                bins, weight = weights[k]
                line[(bins - round(bands[k].centre * transformed)) % count] = (
                    spectrum[bins] * weight
                )
            waves = np.fft.ifft(shifted) * (2 * count / (transformed * rate))
            end = (
                math.ceil(duration * grid_rate) - round(start * grid_rate)
                if is_last
                else round(length * grid_rate)
            )
            context = 0 if is_last else round(CONTEXT * grid_rate)
            for k, z in zip(numbers, waves, strict=True):
                parts[k] = z[
                    round(_GUARD * grid_rate) : round(margin * grid_rate) + end + context + 1
                ]
        yield Window(
            start, min(start + length, math.ceil(duration)), start - CONTEXT, tuple(parts), is_last
        )


def _weights(band: Band, length: int, sample_rate: int) -> tuple[IntArray, FloatArray]:
    """The bins of a spectrum of ``length`` seconds that belong to the band, and their weights.

    Fades are raised cosines, so that the weights of neighbouring bands add up to 1.
    """
    first = max(math.ceil((band.low - band.low_fade) * length), 1)
    last = min(math.floor((band.high + band.high_fade) * length), length * sample_rate // 2)
    bins = np.arange(first, last + 1)
    frequencies = bins / length

    def rise(edge: float, fade: float) -> FloatArray:
        position = np.clip((frequencies - edge) / (2 * fade) + 0.5, 0.0, 1.0)
        return (1 - np.cos(math.pi * position)) / 2

    return bins, rise(band.low, band.low_fade) * (1 - rise(band.high, band.high_fade))
