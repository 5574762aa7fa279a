"""Partition of the spectrum for keyframes: narrow bands around steady tones, which need few keys,
wide bands elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ...core.formats.tracks.listener_tracks import Row
from .analytic import Band

GRID_RATES = (62.5, 125.0, 250.0, 500.0, 1000.0, 2000.0)
"""Rates (hertz) of the grids of key times; the periods are multiples of 0.5 ms."""
FADE = 0.15
"""Half-width of the crossfade of two wide bands relative to the frequency between them."""
HIGHEST_FADE = 40.0
"""Half-width (hertz) of the fade at the last edge; that of the first is half its frequency."""
HALF_TONE = 10.0
"""Half-width (hertz) of the band of a tone, or half the distance to the next one."""
MOST_TONES = 50
MOST_HERTZ = 1100.0

_WINDOW = 1.0  # seconds
_AT_ONCE = 8
_LOUDEST_SHARE = 1e-4
_CONTRAST = 20.0
_NEIGHBOURS = 12
_SPECTRA = 2000
"""Maximum number of spectra, spread evenly over a long track."""


def wide_bands(edges: Sequence[float]) -> tuple[Band, ...]:
    """Bands between ascending ``edges`` (hertz)."""
    return _chain(list(edges), [edges[0] / 2, *(FADE * edge for edge in edges[1:-1]), HIGHEST_FADE])


def bands_for(row: Row, edges: Sequence[float]) -> tuple[Band, ...]:
    """Bands between the first and the last of the ascending ``edges`` (hertz).

    Narrow ones around the tones of the samples; the rest is divided at the edges in between.
    """
    lowest = edges[0]
    highest = edges[-1]
    cuts: dict[float, float] = {lowest: lowest / 2, highest: HIGHEST_FADE}
    tones = [
        tone for tone in _tones(row) if 2 * lowest <= tone <= highest - HIGHEST_FADE - 2 * HALF_TONE
    ]
    if tones and tones[0] > 3 * HALF_TONE:
        cuts[tones[0] - HALF_TONE] = HALF_TONE / 2
    for tone, after in pairwise([*tones, highest]):
        if after < highest and after - tone <= 3 * HALF_TONE:
            cuts[(tone + after) / 2] = (after - tone) / 4
        else:
            cuts[tone + HALF_TONE] = HALF_TONE / 2
            if after < highest:
                cuts[after - HALF_TONE] = HALF_TONE / 2
    for edge in edges[1:-1]:
        if min(abs(edge - cut) - fade for cut, fade in cuts.items()) > FADE * edge:
            cuts[edge] = FADE * edge
    ordered = sorted(cuts)
    return _chain(ordered, [cuts[cut] for cut in ordered])


def _chain(edges: Sequence[float], fades: Sequence[float]) -> tuple[Band, ...]:
    parts = zip(edges[:-1], edges[1:], fades[:-1], fades[1:], strict=True)
    return tuple(
        Band(low, high, first, last, _grid_rate(high + last - low + first))
        for low, high, first, last in parts
    )


def _grid_rate(width: float) -> float:
    return next((rate for rate in GRID_RATES if rate >= 2 * width), GRID_RATES[-1])


def _tones(row: Row) -> list[float]:
    """Frequencies (hertz, ascending) of peaks in the median of the short-time power spectra, that
    is, of steady tones."""
    size = round(_WINDOW * row.sample_rate)
    if row.count < 2 * size:
        return []
    window = np.hanning(size)
    most = round(MOST_HERTZ * _WINDOW) + 1
    starts = range(0, row.count - size + 1, max(size // 2, row.count // _SPECTRA))
    # Several windows are transformed at once, because each call computes the factors of the
    # transform anew.
    groups = (
        [row.read(start, start + size) for start in starts[k : k + _AT_ONCE]]
        for k in range(0, len(starts), _AT_ONCE)
    )
    power = np.median(
        np.concatenate(
            [np.abs(np.fft.rfft(np.array(group) * window)[:, :most]) ** 2 for group in groups]
        ),
        axis=0,
    )
    views = np.lib.stride_tricks.sliding_window_view(
        np.pad(power, _NEIGHBOURS, mode="edge"), 2 * _NEIGHBOURS + 1
    )
    floor = np.median(views, axis=1)
    near = np.lib.stride_tricks.sliding_window_view(np.pad(power, 4), 9)
    standing_out = (
        (power >= np.amax(near, axis=1))
        & (power > _CONTRAST * floor)
        & (power > _LOUDEST_SHARE * np.amax(power))
    )
    tones = np.flatnonzero(standing_out)
    loudest = np.sort(tones[np.argsort(power[tones], kind="stable")[::-1][:MOST_TONES]])
    return [float(tone) / _WINDOW for tone in loudest.tolist()]
