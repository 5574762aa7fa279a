"""Onset detection in sounds: peaks of the spectral flux, refined by the rise of the level.

The flux is that of S. Böck and G. Widmer, "Maximum filter vibrato suppression for onset detection"
(DAFx 2013): the rise of the log amplitude in the bands of a filter bank over the largest of the
neighbouring bands before. A peak is an onset if it exceeds its surroundings, as in S. Dixon, "Onset
detection revisited" (DAFx 2006).
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ..arrays import FloatArray, IntArray

FRAME = 320
"""Samples of a frame: 20 ms at 16 kHz."""
LAG = 2
"""Distance in frames between compared frames."""

_WINDOW = np.hanning(FRAME + 1)[:FRAME]
_BINS = np.unique(np.rint(np.geomspace(1.0, FRAME // 2, 25)[:-1]).astype(np.intp))
"""First bin of each band of the filter bank, 50 Hz per bin; thirds of an octave where bins are
dense enough."""
_COMPRESSION = 1e4
"""Factor of the logarithmic compression: bands well below a ten-thousandth of full scale count as
silent."""
_NEAR, _AROUND = 6, 20
"""Frames to either side in which a peak is the maximum, and from which its threshold is
computed."""
_LEAST, _TIMES, _PERCENTILE = 0.2, 1.5, 75
"""A peak must exceed the first value plus the second times this percentile of its surroundings; the
percentile rejects the beats of an engine."""
_BEFORE, _AFTER = 30, 25
"""Milliseconds before and after a peak in which the rise of the level is searched for."""
_PERIOD = 12
"""Milliseconds of peak hold of the amplitude, so that the periods of a low tone are not onsets."""
_RISE = 1.1
"""Least ratio of the amplitudes after and before an onset, which rejects the ends of events."""
_CLOSEST = 0.03
"""Least distance between two onsets [s]."""
_SHARE = 0.15
"""Fraction of the rise at which an event begins."""


def band_levels(frames: FloatArray) -> FloatArray:
    """The compressed amplitude in each band of ``frames`` (n, FRAME), shape (n, bands); a sine of
    full scale has the amplitude 1."""
    spectra = np.fft.rfft(frames * _WINDOW)[:, :-1]
    power = np.add.reduceat(spectra.real**2 + spectra.imag**2, _BINS, axis=1)
    return np.asarray(np.log10(1.0 + _COMPRESSION * 2.0 / _WINDOW.sum() * np.sqrt(power)))


def flux(levels: FloatArray) -> FloatArray:
    """The flux of each frame from the `LAG`-th on, shape (n - LAG,), of levels (n, bands)."""
    widest = sliding_window_view(
        np.pad(levels[:-LAG], ((0, 0), (1, 1)), mode="edge"), 3, axis=1
    ).max(axis=2)
    return np.asarray(np.maximum(levels[LAG:] - widest, 0.0).mean(axis=1))


def onsets(fluxes: FloatArray, hop: float, power: FloatArray) -> FloatArray:
    """Times of onsets in seconds, ascending. fluxes: shape (n,), ``hop`` seconds apart. power: mean
    square of each millisecond."""
    padded = np.pad(fluxes, _AROUND)
    around = sliding_window_view(padded, 2 * _AROUND + 1)
    near = around[:, _AROUND - _NEAR : _AROUND + _NEAR + 1].max(axis=1)
    peaks = np.flatnonzero(
        (fluxes == near) & (fluxes > _LEAST + _TIMES * np.percentile(around, _PERCENTILE, axis=1))
    )
    times = np.unique(_rises(np.rint(peaks * hop * 1000).astype(np.int64), np.sqrt(power)) / 1000)
    return times[np.diff(times, prepend=-1.0) >= _CLOSEST]


def _rises(middles: IntArray, amplitudes: FloatArray) -> IntArray:
    """Where the rises near ``middles`` begin: the sample after which the amplitude stays above
    `_SHARE` of the rise. Middles without a rise have none.

    ``middles`` (m,): numbers of samples; ``amplitudes``: one a millisecond."""
    held = sliding_window_view(np.pad(amplitudes, (_PERIOD - 1, 0)), _PERIOD).max(axis=1)
    padded = np.pad(held, (_BEFORE, _AFTER))
    windows = sliding_window_view(padded, _BEFORE + _AFTER)[np.minimum(middles, len(amplitudes))]
    floor = windows[:, : _BEFORE // 3].max(axis=1, keepdims=True)
    largest = windows.max(axis=1, keepdims=True)
    low = windows <= floor + _SHARE * (largest - floor)
    columns = np.arange(_BEFORE + _AFTER)
    before = np.where(low & (columns < windows.argmax(axis=1)[:, None]), columns, -1).max(axis=1)
    return np.asarray(
        np.clip(middles - _BEFORE + before + 1, 0, len(amplitudes) - 1)[
            (largest > _RISE * floor)[:, 0]
        ]
    )
