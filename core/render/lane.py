"""The rows of the lane: what listeners and sources feel and emit over time, as bands between two
heights. Blender's timelines, web pages and the study's report fill the same bands."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from .waves import FULL_SCALE, Columns, Waves, as_integers

FLOOR = -60.0
"""Level at the bottom of a row [dB of full scale]; 0 dB is the top."""
GRID = (-40.0, -20.0)
"""Levels with a line across the row."""
_FRAMES = 25.0  # levels a second of a drawn track
_SIZE = 600, 60


class FilledBand(NamedTuple):
    """An area from ``low`` to ``high`` (l, c), parts of a row's height; a line where they are
    equal. ``kind``: "felt" is what of the level is above the threshold of feeling."""

    kind: str
    low: FloatArray
    high: FloatArray


def height_of(level: FloatArray) -> FloatArray:
    """The place of levels in a row, 0 to 1; 0 for NaN."""
    return np.nan_to_num(np.clip(1 - level / FLOOR, 0.0, 1.0))


def bands(parts: Columns, wave: bool = False) -> tuple[FilledBand, ...]:
    """What is drawn of listeners, from the bottom up: level, threshold and what is felt, or else
    the ``wave`` around the middle, its samples in decibels as well."""
    if wave:
        low, high = (_wave_heights().take(part.view(np.uint16)) for part in (parts.low, parts.high))
        # One line, however steep.
        low[:, 1:], high[:, 1:] = (
            np.minimum(low[:, 1:], high[:, :-1]),
            np.maximum(high[:, 1:], low[:, :-1]),
        )
        return (FilledBand("wave", low, high),)
    level = height_of(parts.level)
    threshold = np.where(level > 0, height_of(parts.threshold), 0.0)
    return (
        FilledBand("felt", np.minimum(threshold, level), level),
        FilledBand("threshold", threshold, threshold),
        FilledBand("level", level, level),
    )


@cache
def _wave_heights() -> FloatArray:
    """The height in a row for every 16-bit sample value."""
    values = np.arange(1 << 16, dtype=np.uint16).view(np.int16).astype(np.float64) / FULL_SCALE
    with np.errstate(divide="ignore"):
        return 0.5 + np.sign(values) * height_of(20 * np.log10(np.abs(values))) / 2


def svg(samples: FloatArray, sample_rate: float) -> str:
    """The level of a listener over all its ``samples`` (n,) as an SVG element, stretched over the
    box that holds it; the classes of its paths are the kinds of bands, and "grid"."""
    count, (width, tall) = max(len(samples), 1), _SIZE
    kept = np.zeros((1, count), dtype=np.int16)
    kept[0, : len(samples)] = as_integers(samples)
    waves = Waves([""], 0.0, sample_rate / _FRAMES, kept, filled=True)
    waves.find_levels(sample_rate)
    parts = waves.columns(np.linspace(0.0, count / waves.per_frame, width + 1))
    paths = [
        f'<path class="grid" d="M0 {_y(level / FLOOR)}H{width}" {_UNSCALED}/>' for level in GRID
    ]
    for kind, low, high in bands(parts):
        there = [f"{x} {_y(1 - y)}" for x, y in enumerate(high[0].tolist())]
        back = [f"{x} {_y(1 - y)}" for x, y in enumerate(low[0].tolist())][::-1]
        outline = [*there, *back] if kind == "felt" else there
        paths.append(f'<path class="{kind}" d="M{"L".join(outline)}" {_UNSCALED}/>')
    return (
        f'<svg class="lane" viewBox="0 0 {width} {tall}" preserveAspectRatio="none">'
        f"{''.join(paths)}</svg>"
    )


_UNSCALED = 'vector-effect="non-scaling-stroke"'


def _y(part: float) -> str:
    """A place from the top of an SVG, in whole tenths."""
    return f"{part * _SIZE[1]:.1f}"
