"""Splits samples into the six vibrotactile bands, which add up to the samples again."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ..arrays import FloatArray
from ..scene.bands import BAND_EDGES

_PERIODS = 2
"""Half-length of a low-pass in periods of its edge: its transition is then about an octave wide."""


def bank_reach(sample_rate: float) -> int:
    """Return how many samples before and after a sample its bands depend on: two periods of the
    lowest inner edge (50 ms)."""
    return math.ceil(_PERIODS * sample_rate / BAND_EDGES[1])


def low_pass(edge: float, sample_rate: float) -> FloatArray:
    """Return a linear-phase low-pass, shape (2 bank_reach + 1,), centred: a Hann-windowed sinc,
    gain 1 at 0 Hz and 1/2 at `edge` hertz."""
    reach = bank_reach(sample_rate)
    offsets = np.arange(-reach, reach + 1)
    if edge >= sample_rate / 2:
        return np.asarray(offsets == 0, dtype=np.float64)
    half = math.ceil(_PERIODS * sample_rate / edge)
    window = np.where(
        np.abs(offsets) <= half, 0.5 + 0.5 * np.cos(np.pi / (half + 1) * offsets), 0.0
    )
    kernel = window * np.sinc(2 * edge / sample_rate * offsets)
    return np.asarray(kernel / kernel.sum())


@lru_cache(maxsize=4096)
def bank_response(frequency: float, sample_rate: float) -> FloatArray:
    """Return the gains of the bands for a steady tone of `frequency` hertz, shape (6,). Symmetric
    filters turn no phase."""
    offsets = np.arange(-bank_reach(sample_rate), bank_reach(sample_rate) + 1)
    waves = np.cos(2 * np.pi / sample_rate * frequency * offsets)
    low = np.array([low_pass(edge, sample_rate) @ waves for edge in BAND_EDGES[1:-1]])
    response = np.diff(low, prepend=0.0, append=1.0)
    response.setflags(write=False)
    return response


def split_bands(samples: FloatArray, sample_rate: float) -> FloatArray:
    """Return the bands of `samples`, shape (6, n), where `samples`, shape (n + 2 bank_reach,), goes
    bank_reach further on either side.

    A band is the difference of two low-passes at its edges; the lowest has what is below it, the
    highest what is above. So the sum over the bands is the signal itself, to rounding. The filters
    are symmetric: no delay, no change of phase.
    """
    reach = bank_reach(sample_rate)
    count = len(samples) - 2 * reach
    size = -(-len(samples) // 512) * 512  # few sizes, whose spectra are kept
    low = np.fft.irfft(np.fft.rfft(samples, size) * _low_pass_spectra(sample_rate, size), size)[
        :, reach : reach + count
    ]
    bands = np.empty((len(low) + 1, count))
    bands[0] = low[0]
    np.subtract(low[1:], low[:-1], out=bands[1:-1])
    np.subtract(samples[reach : reach + count], low[-1], out=bands[-1])
    return bands


def bank_spectra(sample_rate: float, size: int) -> FloatArray:
    """Return the gains of the bands for the frequencies of transforms of `size` samples, shape (6,
    size // 2 + 1)."""
    return np.diff(_low_pass_spectra(sample_rate, size), axis=0, prepend=0.0, append=1.0)


@lru_cache(maxsize=16)
def _low_pass_spectra(sample_rate: float, size: int) -> FloatArray:
    """Return the low-passes' spectra for transforms of `size`, centred on sample 0, where a
    symmetric filter's spectrum is real."""
    kernels = np.zeros((len(BAND_EDGES) - 2, size))
    for kernel, edge in zip(kernels, BAND_EDGES[1:-1], strict=True):
        taps = low_pass(edge, sample_rate)
        kernel[: len(taps)] = taps
    return np.fft.rfft(np.roll(kernels, -bank_reach(sample_rate), axis=1)).real
