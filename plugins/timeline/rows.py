"""Layout of the lane over a timeline: a row per source and per listener, and its places in pixels;
independent of the GPU."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain, zip_longest
from typing import NamedTuple

import numpy as np

from ...addon.blender.words import ui_text
from ...addon.view.hud import SMALL_TEXT, Hud, HudBuilder
from ...addon.view.render_data import Drawn, Place
from ...addon.view.symbols import Symbol
from ...core.arrays import BoolArray, FloatArray
from ...core.render.lane import height_of

# Points at a user interface scale of 1.
_ROW, _LEAST_ROW, _GAP = 36.0, 11.0, 1.0
_NAME_WIDTH, _RULER = 110.0, 25.0
_LEFT, _SWATCH = 14.0, 4.0  # Blender's arrow that shows the channels is left of the names
SMALL, _TALL = 100.0, 260.0
"""Height up to which a region has neither scroll bar nor markers, as the Timeline at first."""
_BOTTOM = 22.0  # that these take
_SHARE = 0.66  # part of the height of a tall region
_MARK = 9.0
_LINE = 0.75  # half the thickness of a line [pixels]


class LaneRow(NamedTuple):
    """The row of a source or listener: its lower edge and its height [pixels]."""

    name: str
    is_source: bool
    low: float
    height: float


class Colours(NamedTuple):
    """Colours of the theme, RGBA: of the ground of a row, texts, sources and listeners."""

    ground: tuple[float, ...]
    ink: tuple[float, ...]
    source: tuple[float, ...]
    listener: tuple[float, ...]


class Mark(NamedTuple):
    """A one-shot of a source at the keyframe ``key`` of its trigger, at ``frame``."""

    source: str
    key: int
    frame: float


def rows_of(
    sources: Sequence[str],
    listeners: Sequence[str],
    first: Sequence[str],
    height: float,
    scale: float,
) -> tuple[LaneRow, ...]:
    """The rows of a lane, from the top down. If not all fit, those that are named ``first``, then
    listeners and sources in turn; if one fits, a source and a listener share its place.

    Args:
        sources: their names.
        listeners: their names.
        first: names that always have a row.
        height: of the region [pixels].
        scale: pixels per point.
    """
    bottom = _BOTTOM * scale if height > SMALL * scale else scale
    room = height - bottom - _RULER * scale
    if height > _TALL * scale:
        room = min(_SHARE * (height - bottom), room)
    every = [*((name, True) for name in sources), *((name, False) for name in listeners)]
    turns = zip_longest(reversed(every[len(sources) :]), reversed(every[: len(sources)]))
    ranked = sorted(
        dict.fromkeys(filter(None, chain.from_iterable([*turns][::-1]))),
        key=lambda item: item[0] not in first,
    )
    places = max(int(room / (_LEAST_ROW * scale)), 0)
    shown = set(ranked[:places])
    if places == 1:
        shown = set({is_source: (name, is_source) for name, is_source in ranked[::-1]}.values())
    kept = [item for item in every if item in shown]
    places = min(places, len(kept))
    tall = min(room / max(places, 1), _ROW * scale)
    return tuple(
        LaneRow(*item, bottom + max(places - k - 1, 0) * tall, tall - _GAP * scale)
        for k, item in enumerate(kept)
    )


def grounds(rows: Sequence[LaneRow], width: float, colours: Colours) -> Hud:
    """The background of the rows."""
    builder = HudBuilder(1.0)
    for row in rows:
        builder.plate((0, row.low), (width, row.low + row.height), colours.ground, 0.0)
    return builder.build()


def names(
    rows: Sequence[LaneRow],
    marks: Sequence[Place],
    hidden: int,
    colours: Colours,
    scale: float,
) -> Hud:
    """The names at the left, side by side where rows share a place, with the colour of their kind;
    the number of hidden rows, and the one-shots.

    Args:
        rows: of the lane.
        marks: places of the one-shots [pixels].
        hidden: number of rows without room.
        colours: of the theme.
        scale: pixels per point.
    """
    builder = HudBuilder(scale)
    right = 0.0
    for number, row in enumerate(rows):
        is_beside = number > 0 and row.low == rows[number - 1].low
        left = right if is_beside else _LEFT
        text = builder.fitted(row.name, _NAME_WIDTH, SMALL_TEXT)
        if number == len(rows) - 1 and hidden:
            text = f"{text}, {ui_text('and {} more', hidden)}"
        low = (row.low + row.height / 2) / scale - 5
        start = left + _SWATCH + 3
        right = start + builder.width(text, SMALL_TEXT) + 3
        builder.plate((left, low), (right, low + 10), (*colours.ground[:3], 0.9), 0.0)
        kind = colours.source if row.is_source else colours.listener
        builder.plate((left, low), (left + _SWATCH, low + 10), (*kind, 1.0), 0.0)
        builder.text(text, (start, low + 2), colours.ink, SMALL_TEXT)
    for x, y in marks:
        builder.symbol((x / scale, y / scale), Symbol.IMPACT, _MARK, colours.source[:3])
    return builder.build()


def strip(
    rows: Sequence[LaneRow], x: FloatArray, low: FloatArray, high: FloatArray, known: BoolArray
) -> Drawn:
    """A band in the rows as one strip of triangles (v, 2) [pixels], at least a line.

    Args:
        rows: of the lane.
        x: of the columns (c,) [pixels].
        low: lower edge in each row, 0 to 1 (r, c).
        high: upper edge in each row, 0 to 1 (r, c).
        known: columns with samples; the others have no area (c,).
    """
    base, tall = (
        np.array([getattr(row, name) for row in rows])[:, None] for name in LaneRow._fields[2:]
    )
    corners = np.empty((*low.shape, 2, 2), dtype=np.float32)
    corners[..., 0] = x[:, None]
    corners[..., 0, 1] = base + np.where(known, low * tall - _LINE, 0.0)
    corners[..., 1, 1] = base + np.where(known, high * tall + _LINE, 0.0)
    strips = corners.reshape(len(rows), -1, 2)
    # Joined by triangles without an area.
    return np.concatenate([strips[:, :1], strips, strips[:, -1:]], axis=1).reshape(-1, 2)


def stems(rows: Sequence[LaneRow], x: FloatArray, gains: FloatArray) -> Drawn:
    """Impacts at ``x`` (m,) that arrive with ``gains`` (m, r) as the ends (v, 2) of lines, as high
    as levels."""
    place, who = np.nonzero(gains > 0)
    base, tall = (
        np.array([getattr(row, name) for row in rows])[who] for name in LaneRow._fields[2:]
    )
    ends = np.empty((len(place), 2, 2), dtype=np.float32)
    ends[..., 0] = x[place][:, None]
    ends[:, 0, 1] = base
    ends[:, 1, 1] = base + tall * height_of(20 * np.log10(gains[place, who]))
    return ends.reshape(-1, 2)


def snapped(frame: float, targets: FloatArray, reach: float) -> float:
    """The nearest of ``targets`` within ``reach`` frames, else a whole frame."""
    away = np.abs(targets - frame)
    if len(away) and away.min() <= reach:
        return float(targets[away.argmin()])
    return float(round(frame))
