"""The rows of a lane: what listeners feel over time, as bands between two heights. Blender's
timelines, web pages and the study's report fill the same bands."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..scene.values import Listener
from .levels import LEVEL_SECONDS, level_and_margin, vibration_rms

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


def bands(level: FloatArray, threshold: FloatArray) -> tuple[FilledBand, ...]:
    """What is drawn of listeners, from the bottom up: what is felt, the threshold of feeling and
    the level.

    Args:
        level: in each column (l, c) [dB of full scale].
        threshold: the level of this vibration at the threshold of feeling (l, c), NaN for silence.
    """
    high = height_of(level)
    edge = np.where(high > 0, height_of(threshold), 0.0)
    return (
        FilledBand("felt", np.minimum(edge, high), high),
        FilledBand("threshold", edge, edge),
        FilledBand("level", high, high),
    )


def level_and_threshold(
    samples: FloatArray, sample_rate: float, listeners: Sequence[Listener] = ()
) -> tuple[FloatArray, FloatArray]:
    """The level (l,) of ``samples`` (l, n) [dB of full scale], minus infinity for silence; and the
    level (l,) that the same vibration would have at the threshold of feeling of ``listeners``, NaN
    for silence."""
    level, margin = level_and_margin(samples, sample_rate, listeners)
    with np.errstate(invalid="ignore"):
        threshold = level - margin
    return level, np.where(np.isfinite(threshold), threshold, np.nan)


def levels_over_time(
    samples: FloatArray, sample_rate: float, per_frame: float, listeners: Sequence[Listener] = ()
) -> tuple[FloatArray, FloatArray]:
    """Levels and thresholds (l, f) of ``samples`` (l, n), n > 0, in frames of ``per_frame``
    samples: the level of the last `LEVEL_SECONDS` up to the end of each frame, as the meters show
    it."""
    count, length = samples.shape
    frames = math.ceil(length / per_frame - 1e-9)
    level = np.empty((count, frames), dtype=np.float32)
    threshold = np.full_like(level, np.nan)
    width = round(LEVEL_SECONDS * sample_rate)
    for frame in range(frames):
        end = math.ceil((frame + 1) * per_frame)
        with np.errstate(divide="ignore"):
            level[:, frame] = 20 * np.log10(
                vibration_rms(samples[:, max(end - width, 0) : end], sample_rate)
            )
    for begin in range(0, length, width):
        _, felt = level_and_threshold(samples[:, begin : begin + width], sample_rate, listeners)
        part = slice(round(begin / per_frame), math.ceil((begin + width) / per_frame))
        threshold[:, part] = felt[:, None]
    return level, threshold


def highest(values: FloatArray, edges: FloatArray) -> FloatArray:
    """The highest of values (r, f) of frames in each part between ``edges`` (c + 1,), in frames
    from the first on."""
    count = values.shape[1]
    first = np.clip(np.floor(edges[:-1]), 0, count - 1).astype(np.int64)
    end = max(min(math.ceil(edges[-1]), count), int(first[-1]) + 1)
    return np.asarray(np.maximum.reduceat(values[:, :end], first, axis=1))


def svg(samples: FloatArray, sample_rate: float) -> str:
    """The level of a listener over all its ``samples`` (n,) as an SVG element, stretched over the
    box that holds it; the classes of its paths are the kinds of bands, and "grid"."""
    width, tall = _SIZE
    per_frame = sample_rate / _FRAMES
    known = samples[None] if len(samples) else np.zeros((1, 1))
    level, threshold = levels_over_time(known, sample_rate, per_frame)
    edges = np.linspace(0.0, known.shape[1] / per_frame, width + 1)
    at = np.minimum(np.floor(edges[:-1]), level.shape[1] - 1).astype(np.int64)
    paths = [f'<path class="grid" d="M0 {_y(line / FLOOR)}H{width}" {_UNSCALED}/>' for line in GRID]
    for kind, low, high in bands(highest(level, edges), threshold[:, at]):
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
