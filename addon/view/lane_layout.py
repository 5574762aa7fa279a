"""Layout of the lane over a timeline: a row per listener with its wave, the threshold of feeling
and impacts; independent of the GPU."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from bpy.app.translations import pgettext_iface as iface_

from ...core.arrays import BoolArray, FloatArray
from ...core.render.waves import FULL_SCALE, Columns, Waves
from ..blender.text import Measure, shortened
from .colour_map import AmplitudeScale
from .hud import FAINT_INK, INK, SMALL_TEXT, Hud, HudBuilder
from .levels import FLOOR
from .render_data import Drawn, Points, Shape, points_of

# Points at a user interface scale of 1.
_ROW, _LEAST_ROW, _GAP = 30.0, 9.0, 1.0
_NAME_WIDTH, _RULER = 110.0, 26.0
_BESIDE_IMPACT = 8.0  # of two impacts nearer to each other the stronger one is drawn
_SHARE = 0.66  # part of the region's height
_BACKGROUND = (0.075, 0.075, 0.085, 0.72)
_COARSE = 4  # columns that share a threshold
_SILENCE = 0.5  # half the thickness of a wave at least [pixels]


@dataclass(frozen=True, slots=True)
class Row:
    """The row of a listener: its middle and half of its height [pixels]."""

    listener: str
    middle: float
    half: float


def rows_of(
    listeners: Sequence[str], first: str, height: float, bottom: float, scale: float
) -> tuple[Row, ...]:
    """The rows, from the top down to ``bottom``, of a region of ``height`` pixels. If not all fit,
    ``first`` and the foremost others; none if not even two fit."""
    room = min(_SHARE * (height - bottom), height - bottom - _RULER * scale)
    count = min(len(listeners), int(room / (_LEAST_ROW * scale)))
    if count < min(len(listeners), 2):
        return ()
    shown = [name for name in listeners if name == first][:count]
    shown += [name for name in listeners if name != first][: count - len(shown)]
    shown.sort(key=list(listeners).index)
    tall = min(room / max(count, 1), _ROW * scale)
    half = (tall - _GAP * scale) / 2
    return tuple(Row(name, bottom + (count - k - 0.5) * tall, half) for k, name in enumerate(shown))


def plates(rows: Sequence[Row], width: float, scale: float) -> Hud:
    """The background of the waves: a plate per row."""
    builder = HudBuilder(scale)
    for row in rows:
        builder.plate((0, row.middle - row.half), (width, row.middle + row.half), _BACKGROUND, 0.0)
    return builder.build()


def names(rows: Sequence[Row], hidden: int, scale: float, measure: Measure) -> Hud:
    """The names of the listeners, at the left, and the number of hidden ones."""
    builder, size = HudBuilder(scale), SMALL_TEXT * scale
    for row in rows:
        text = shortened(row.listener, _NAME_WIDTH * scale, size, measure)
        left, low = 4 * scale, row.middle - 5 * scale
        builder.plate(
            (left - 2 * scale, low),
            (left + measure(text, size) + 2 * scale, low + 10 * scale),
            (*_BACKGROUND[:3], 0.6),
            2.0,
        )
        builder.text(text, (left, low + 2 * scale), INK, SMALL_TEXT)
    if hidden and rows:
        words = iface_("and {} more").format(hidden)
        builder.text(
            words, ((_NAME_WIDTH + 12) * scale, rows[-1].middle - 3 * scale), FAINT_INK, SMALL_TEXT
        )
    return builder.build()


def wave_strip(rows: Sequence[Row], x: FloatArray, parts: Columns, numbers: Sequence[int]) -> Drawn:
    """The waves of the listeners ``numbers`` as a strip of triangles (v, 2) [pixels], the columns
    at ``x`` (c,): its thickness is 0 without data and one pixel for silence."""
    middle, half = _places(rows)
    low, high = (
        _heights().take(values[list(numbers)].view(np.uint16)) * half
        for values in (parts.low, parts.high)
    )
    # One line, however steep.
    low[:, 1:], high[:, 1:] = (
        np.minimum(low[:, 1:], high[:, :-1]),
        np.maximum(high[:, 1:], low[:, :-1]),
    )
    thin = np.where(parts.known, _SILENCE, 0.0)
    return _strip(
        x,
        middle + np.where(parts.known, low, 0.0) - thin,
        middle + np.where(parts.known, high, 0.0) + thin,
    )


def threshold_strip(
    rows: Sequence[Row], x: FloatArray, parts: Columns, numbers: Sequence[int]
) -> Drawn:
    """The thresholds of feeling as a strip of triangles, a pixel thick over and under the middle of
    each row."""
    middle, half = _places(rows)
    level = np.clip(1 - parts.threshold[list(numbers), ::_COARSE] / FLOOR, 0.0, 1.0) * half
    heard = np.isfinite(level) & parts.known[::_COARSE]
    level, thick = np.where(heard, level, 0.0), np.where(heard, _SILENCE, 0.0)
    return np.concatenate(
        [
            _strip(x[::_COARSE], middle + side * level - thick, middle + side * level + thick)
            for side in (-1, 1)
        ]
    )


def impacts(
    rows: Sequence[Row],
    waves: Waves,
    numbers: Sequence[int],
    edges: FloatArray,
    known: BoolArray,
    scale: float,
) -> Points:
    """The impacts in the columns between ``edges`` (c + 1,) [frames] that are ``known``, larger and
    lighter for higher amplitudes."""
    began, gains = waves.impacts
    x = (began - edges[0]) / (edges[1] - edges[0])
    is_shown = (x >= 0) & (x < len(known))
    is_shown[is_shown] = known[x[is_shown].astype(np.int64)]
    felt = gains[:, list(numbers)]
    place, who = np.nonzero((felt > 0) & is_shown[:, None])
    gain, slot = felt[place, who], np.floor(x[place] / (_BESIDE_IMPACT * scale))
    order = np.lexsort((gain, slot, who))
    strongest = np.ones(len(order), dtype=np.bool_)
    strongest[:-1] = (np.diff(slot[order]) != 0) | (np.diff(who[order]) != 0)
    place, who, gain = place[order][strongest], who[order][strongest], gain[order][strongest]
    middle, half = _places(rows)
    strengths = AmplitudeScale(FLOOR)
    size = np.minimum(6.0 + 12.0 * strengths.place(gain), 2 * half[who, 0] / scale + 3.0)
    position = np.column_stack([x[place], middle[who, 0], np.zeros(len(place))])
    return points_of(position, strengths.colour(gain), 1.0, size, Shape.IMPACT)


def _places(rows: Sequence[Row]) -> tuple[FloatArray, FloatArray]:
    """Middles and half heights of rows, (r, 1) each."""
    return np.array([[row.middle] for row in rows]).reshape(-1, 1), np.array(
        [[row.half] for row in rows]
    ).reshape(-1, 1)


def _strip(x: FloatArray, low: FloatArray, high: FloatArray) -> Drawn:
    """One strip of triangles for all rows (r, c), joined by triangles without an area."""
    corners = np.empty((*low.shape, 2, 2), dtype=np.float32)
    corners[..., 0] = x[:, None]
    corners[..., 0, 1], corners[..., 1, 1] = low, high
    strips = corners.reshape(len(low), -1, 2)
    return np.concatenate([strips[:, :1], strips, strips[:, -1:]], axis=1).reshape(-1, 2)


@cache
def _heights() -> Drawn:
    """The height in a row, -1 to 1, for every 16-bit sample value: decibels from `FLOOR` in the
    middle to full scale at the edges."""
    values = np.arange(1 << 16, dtype=np.uint16).view(np.int16).astype(np.float64) / FULL_SCALE
    with np.errstate(divide="ignore"):
        level = 20 * np.log10(np.abs(values))
    return (np.sign(values) * np.clip(1 - level / FLOOR, 0.0, 1.0)).astype(np.float32)
