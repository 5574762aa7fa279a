"""The pitch of a sound by autocorrelation.

P. Boersma, "Accurate short-term analysis of the fundamental frequency and the harmonics-to-noise
ratio of a sampled sound" (IFA Proceedings 17, 1993): the autocorrelation of a windowed frame over
that of the window, its peaks interpolated by parabolas, short periods preferred.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray

FRAME = 1024
"""Samples of a frame."""
LOWEST, HIGHEST = 40.0, 2000.0
"""Range of pitches that are detected [Hz]."""
_OCTAVE_COST = 0.02
_VOICED = 0.5
"""Least height of the autocorrelation peak of a pitched frame."""
_FAINT = 1e-8
"""Mean square below which a frame has no pitch."""
_WINDOW = np.hanning(FRAME + 1)[:FRAME]


def _autocorrelation(frames: FloatArray, count: int) -> FloatArray:
    spectra = np.fft.rfft(frames, 2 * FRAME)
    return np.fft.irfft(spectra.real**2 + spectra.imag**2)[:, :count]


def pitches(frames: FloatArray, rate: float) -> FloatArray:
    """The pitch of each of ``frames`` (n, FRAME) at ``rate`` hertz, shape (n,), 0 for frames
    without pitch."""
    shortest = int(rate / HIGHEST)
    longest = int(rate / LOWEST)
    correlated = _autocorrelation(
        (frames - frames.mean(axis=1, keepdims=True)) * _WINDOW, longest + 2
    )
    energy = correlated[:, :1]
    correlated = (
        correlated / np.maximum(energy, 1e-300) * (_OF_WINDOW[0] / _OF_WINDOW[: longest + 2])
    )
    before, here, after = (
        correlated[:, shortest + shift : longest + 1 + shift] for shift in (-1, 0, 1)
    )
    bend = 2.0 * here - before - after
    shift = np.divide(after - before, 2.0 * bend, out=np.zeros_like(bend), where=bend > 1e-12)
    height = here + (after - before) * shift / 4.0
    lags = np.arange(shortest, longest + 1)
    score = np.where(
        (here > before) & (here >= after), height - _OCTAVE_COST * np.log2(lags), -np.inf
    )
    best = score.argmax(axis=1)
    rows = np.arange(len(frames))
    heard = (
        (height[rows, best] >= _VOICED)
        & np.isfinite(score[rows, best])
        & (energy[:, 0] > _FAINT * (_WINDOW**2).sum())
    )
    return np.where(heard, rate / (lags[best] + shift[rows, best]), 0.0)


_OF_WINDOW = _autocorrelation(_WINDOW[None], FRAME)[0]
