"""Band-limited interpolation by the windowed sinc (Smith, Digital Audio Resampling, 2002), and
resampling."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ..arrays import FloatArray

ZERO_CROSSINGS = 16
"""Half-width of the kernel in samples of the lower of the two rates."""

_KAISER_BETA = 9.0
_PHASES = 1024
_GRID = 2.0**20
_BATCH = 1 << 19
_TERMS = 9


def kernel_weights(phases: FloatArray, stretch: float = 1.0) -> FloatArray:
    """Return the weights of the samples around positions that lie `phases` (0 to 1, shape (n,))
    beyond a sample; each row sums to 1.

    Shape (n, 2 reach) with reach = ceil(16 stretch): the weights of samples 1 - reach to reach,
    counted from the sample before. stretch: samples in per sample out where the rate falls, else 1;
    the kernel is that much longer and its cut-off that much lower.
    """
    reach = math.ceil(ZERO_CROSSINGS * stretch)
    scaled = (np.arange(1 - reach, reach + 1) - phases[:, None]) / stretch
    inside = np.maximum(1.0 - (scaled / ZERO_CROSSINGS) ** 2, 0.0)
    weights = np.sinc(scaled) * np.i0(_KAISER_BETA * np.sqrt(inside)) * (inside > 0.0)
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def interpolate(samples: FloatArray, positions: FloatArray, stretch: float = 1.0) -> FloatArray:
    """Return the band-limited values of `samples`, shape (k, m), silent beyond their ends, at
    `positions`, shape (n,), in samples.

    Shape (k, n). Positions are rounded to 2^-20 of a sample, so that a position that equals a
    sample up to rounding has that sample's value. Weights come from a table of 1,024 phases (fewer
    for a longer kernel), straight lines between them. Up to 0.4 times the lower of the sample rates
    the error is below 1e-4 of the amplitude.
    """
    result = np.empty((len(samples), len(positions)))
    batch = max(_BATCH // math.ceil(2 * ZERO_CROSSINGS * stretch), 1)
    for begin in range(0, len(positions), batch):
        result[:, begin : begin + batch] = _interpolated(
            samples, positions[begin : begin + batch], stretch
        )
    return result


def _interpolated(samples: FloatArray, positions: FloatArray, stretch: float) -> FloatArray:
    reach = math.ceil(ZERO_CROSSINGS * stretch)
    # Beyond the ends all samples are 0, so positions are clipped one kernel away.
    wanted = (
        np.round(np.clip(positions, -reach - 0.5, samples.shape[1] + reach - 0.5) * _GRID) / _GRID
    )
    before = np.floor(wanted)
    phase = wanted - before
    window = before.astype(np.intp) + (1 - reach)
    first = int(np.min(window))
    last = int(np.max(window)) + 2 * reach
    near = samples[:, max(first, 0) : max(last, 0)]
    if first < 0 or last > samples.shape[1]:
        near = np.pad(near, ((0, 0), (min(max(-first, 0), last - first), last - first)))[
            :, : last - first
        ]
    window -= first
    one_phase = bool((phase == phase[0]).all())
    if one_phase and phase[0] == 0.0 and stretch == 1.0:
        return near[:, window + (reach - 1)]
    if one_phase and last - first <= 2 * (len(window) + 2 * reach):
        weights = _table_weights(phase[:1], stretch)[0]
        return np.stack([np.correlate(row, weights, "valid") for row in near])[:, window]
    windows = sliding_window_view(near, 2 * reach, axis=1)[:, window]
    return np.asarray(np.einsum("knt,nt->kn", windows, _table_weights(phase, stretch)))


def local_polynomials(samples: FloatArray) -> FloatArray:
    """Return polynomials for the values between `samples`, shape (k, m), m >= 32: shape (k, m - 31,
    9).

    The value at position i + 15 + p, with 0 <= p < 1, is the sum over d of result[:, i, d] (2 p -
    1)^d. They equal the kernel of `interpolate` to 1e-6, and need no weights per phase, which is
    efficient for many positions in the same samples (Farrow, 1988).
    """
    windows = sliding_window_view(samples, 2 * ZERO_CROSSINGS, axis=1)
    return np.asarray(np.einsum("knw,dw->knd", windows, _kernel_polynomials()))


@lru_cache(maxsize=1)
def _kernel_polynomials() -> FloatArray:
    """Return the kernel's weights as polynomials in 2 p - 1 that fit at the Chebyshev nodes, shape
    (9, 32)."""
    nodes = np.cos(np.pi * (np.arange(_TERMS) + 0.5) / _TERMS)
    weights = kernel_weights((nodes + 1.0) / 2.0)
    return np.linalg.solve(np.vander(nodes, _TERMS, increasing=True), weights)


def resample(samples: FloatArray, rate: float, new_rate: float) -> FloatArray:
    """Return `samples`, shape (n,), at `new_rate` instead of `rate` (hertz), shape (ceil(n ·
    new_rate / rate),), by libsoxr.

    Sample 0 keeps its time. Frequencies above the new Nyquist frequency are filtered out. Raises
    ValueError if the ratio of the rates is too large.
    """
    if rate == new_rate:
        return samples.copy()
    import soxr

    ratio = Fraction(new_rate).limit_denominator(1_000_000) / Fraction(rate).limit_denominator(
        1_000_000
    )
    count = -(-len(samples) * ratio.numerator // ratio.denominator)
    try:
        result = np.asarray(
            soxr.resample(
                np.ascontiguousarray(samples, dtype=np.float64), rate, new_rate, quality="HQ"
            )
        )[:count]
    except RuntimeError as error:
        raise ValueError(f"{rate:g} samples a second can't be made {new_rate:g}: {error}") from None
    return np.pad(result, (0, count - len(result)))


def _table_weights(phase: FloatArray, stretch: float) -> FloatArray:
    table = _table(stretch)
    position = phase * (len(table) - 1)
    row = position.astype(np.intp)
    share = (position - row)[:, None]
    return table[row] + share * (table[row + 1] - table[row])


@lru_cache(maxsize=64)
def _table(stretch: float) -> FloatArray:
    return kernel_weights(np.linspace(0.0, 1.0, max(math.ceil(_PHASES / stretch), 16) + 1), stretch)
