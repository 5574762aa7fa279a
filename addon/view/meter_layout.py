"""Layout of the meters over a viewport: a bar per listener, and the body, independent of the
GPU."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from bpy.app.translations import pgettext_iface as iface_

from ...core.frozen import frozen
from ...core.scene.body_map import HALF_WIDTH, HEIGHT, Spot, View, figure
from ..blender.words import ui_text
from .colour_map import colour_table
from .hud import FAINT_INK, INK, SMALL_TEXT, Hud, HudBuilder
from .levels import LEAST, Level, place_of
from .render_data import SOURCE_COLOUR, Place, Size

Colour = tuple[float, ...]

# Points at a user interface scale of 1.
PADDING, GAP = 8.0, 8.0
ROW, BAR = 17.0, 9.0
MARGIN_WIDTH, SWITCH_WIDTH = 48.0, 15.0
LEAST_NAME_WIDTH, NAME_WIDTH = 48.0, 130.0
LEAST_BAR_WIDTH, BAR_WIDTH = 60.0, 150.0
FIGURE_HEIGHT = 140.0
MOST_ROWS = 12

VIEWS: tuple[View, ...] = ("front", "back")
_TRACK = (0.20, 0.20, 0.22, 1.0)
_ABSENT = (0.26, 0.26, 0.28, 1.0)
_NOT_FELT = (0.42, 0.42, 0.44, 1.0)
_WHITE = (0.97, 0.97, 0.97, 1.0)
_MARK = (*SOURCE_COLOUR.tolist(), 1.0)
_OFF = (0.45, 0.45, 0.47, 1.0)
SWITCHES = {"S": "solo", "M": "muted"}
"""Letters of the switches of a row, and the properties of a listener that they set."""


def colour_of(level: Level) -> Colour:
    """Colour by margin, grey if it is not felt."""
    if not level.is_felt:
        return _NOT_FELT
    return (*colour_table()[round(level.place * (len(colour_table()) - 1))].tolist(), 1.0)


@frozen
class _ColumnWidths:
    """Widths in points of names and bars; margins and switches have the same always."""

    name: float
    bar: float

    @property
    def width(self) -> float:
        return self.name + self.bar + MARGIN_WIDTH + 2 * SWITCH_WIDTH

    @classmethod
    def within(cls, across: float, names: float) -> _ColumnWidths | None:
        """Columns in ``across`` points if the longest name takes ``names``; None if there is not
        enough room. Bars become narrow first, then names are shortened."""
        values = MARGIN_WIDTH + 2 * SWITCH_WIDTH
        wanted = min(names + 8.0, NAME_WIDTH)
        bar = min(max(across - wanted - values, LEAST_BAR_WIDTH), BAR_WIDTH)
        name = min(wanted, across - bar - values)
        return cls(name, bar) if name >= min(LEAST_NAME_WIDTH, names + 8.0) else None


@frozen
class _Layout:
    """The elements that fit: the levels shown, their columns, and the body."""

    shown: tuple[Level, ...]
    hidden: int  # listeners that are not shown
    columns: _ColumnWidths
    body: bool

    @property
    def height(self) -> float:
        """Points."""
        rows = 1 + len(self.shown) + (self.hidden > 0)
        return rows * ROW + 2 * PADDING + (FIGURE_HEIGHT + ROW) * self.body


def meter_hud(
    levels: Sequence[Level],
    room: Size,
    scale: float,
    title: str = "",
    *,
    body: bool = True,
    spots: Sequence[Spot] = (),
    switched: Mapping[str, str] | None = None,
) -> Hud:
    """The meters, their lower left corner at the origin. If there is not enough room, these are
    left out in order: body, listeners, everything.

    Args:
        levels: Of all listeners.
        room: Width and height [pixels].
        scale: Pixels per point.
        title: Above the names.
        body: Whether the body is shown where listeners have a body part.
        spots: The actuators that it shows.
        switched: Letters of the switches that are on, by listener.
    """
    builder = HudBuilder(scale)
    names = max(map(builder.width, (title, *(level.title for level in levels))))
    layout = _layout(levels, (room[0] / scale, room[1] / scale), names, body)
    if layout is None:
        return builder.build()
    columns = layout.columns
    width = layout.columns.width + 2 * PADDING
    height = layout.height
    builder.panel((0.0, 0.0), (width, height), 6.0)
    x = PADDING
    y = height - PADDING
    _add_heads(builder, (x, y), title, columns)
    y -= ROW
    for level in layout.shown:
        y -= ROW
        _add_row(builder, (x, y), level, columns, (switched or {}).get(level.listener, ""))
    if layout.hidden:
        y -= ROW
        builder.text(ui_text("and {} more", layout.hidden), (x, y + 4), FAINT_INK)
    if layout.body:
        parts = {level.body_part: level for level in levels if level.body_part}
        left = x + (columns.width - 4 * FIGURE_HEIGHT / HEIGHT * HALF_WIDTH) / 2
        add_body(builder, (left, y - (FIGURE_HEIGHT + ROW)), FIGURE_HEIGHT, parts, spots)
    return builder.build()


def _layout(
    levels: Sequence[Level],
    room: Size,
    names: float,
    body: bool,
) -> _Layout | None:
    """The elements of the meters that fit into the room; None if not even two listeners do.

    Args:
        levels: of the listeners.
        room: width and height [points].
        names: width of the longest name [points].
        body: whether the figures are wanted.
    """
    columns = _ColumnWidths.within(room[0] - 2 * PADDING, names)
    rows = min(int((room[1] - 2 * PADDING) / ROW) - 1, MOST_ROWS)
    if columns is None or not levels or rows < min(len(levels), 2):
        return None
    shown = tuple(levels) if len(levels) <= rows else _strongest(levels, rows - 1)
    wanted = _Layout(shown, len(levels) - len(shown), columns, False)
    has_width = columns.width >= 4 * FIGURE_HEIGHT / HEIGHT * HALF_WIDTH
    if body and has_width and any(level.body_part for level in levels):
        wanted = _fitting(wanted, replace(wanted, body=True), room[1])
    return wanted


def _fitting(layout: _Layout, larger: _Layout, height: float) -> _Layout:
    return larger if larger.height <= height else layout


def _strongest(levels: Sequence[Level], most: int) -> tuple[Level, ...]:
    """The strongest listeners, in their original order."""
    chosen = sorted(range(len(levels)), key=lambda k: -levels[k].margin)[:most]
    return tuple(levels[k] for k in sorted(chosen))


def _add_heads(builder: HudBuilder, corner: Place, title: str, columns: _ColumnWidths) -> None:
    """Add the title, the scale of the bars, and the column headings."""
    x = corner[0]
    base = corner[1] - 12
    builder.text(builder.fitted(title, columns.name - 6), (x, base), INK)
    left = x + columns.name
    width = columns.bar - 8
    ticks = (LEAST, 0.0, 20.0) if columns.bar > 90 else (0.0,)
    for tick in ticks:
        words = f"{tick:+.0f}".replace("-", "\N{MINUS SIGN}") if tick else "0"
        half = builder.width(words, SMALL_TEXT) / 2
        place = min(max(left + place_of(tick) * width - half, left), left + width - half)
        builder.text(words, (place, base), FAINT_INK, SMALL_TEXT)
    words = builder.fitted(iface_("Margin", "Haptics"), MARGIN_WIDTH, SMALL_TEXT)
    builder.text(words, (left + columns.bar, base), FAINT_INK, SMALL_TEXT)


def _add_row(
    builder: HudBuilder, corner: Place, level: Level, columns: _ColumnWidths, switched: str
) -> None:
    """Add name, bar, margin and switches of a listener. The bar is the margin, the orange mark the
    threshold of feeling. ``switched``: "S" where it is solo, "M" where it is muted."""
    x, y = corner
    base = y + 4
    builder.text(builder.fitted(level.title, columns.name - 6), (x, base), INK)
    left = x + columns.name
    width = columns.bar - 8
    low = y + (ROW - BAR) / 2
    high = y + (ROW + BAR) / 2
    builder.plate((left, low), (left + width, high), _TRACK, 2.0)
    if level.place > 0.01:
        builder.plate((left, low), (left + level.place * width, high), colour_of(level), 2.0)
    place = left + place_of(0.0) * width
    builder.plate((place - 0.8, low - 2), (place + 0.8, high + 2), _MARK, 0.0)
    values = left + columns.bar
    ink = INK if level.is_felt else FAINT_INK
    builder.text(level.margin_text(), (values, base), ink)
    for number, switch in enumerate(SWITCHES):
        is_on = switch in switched
        place = values + MARGIN_WIDTH + number * SWITCH_WIDTH
        builder.target((place, y), (place + SWITCH_WIDTH, y + ROW), level.listener, switch)
        builder.text(switch, (place + 3, base), _MARK if is_on else _OFF, SMALL_TEXT)
    builder.target((x, y), (x + columns.width, y + ROW), level.listener)


def add_body(
    builder: HudBuilder,
    corner: Place,
    height: float,
    parts: Mapping[str, Level],
    spots: Sequence[Spot],
) -> None:
    """Draw a figure from the front and one from behind; parts with a listener and actuators light
    up by their level.

    Args:
        builder: collects the elements.
        corner: lower left corner of both.
        height: of the figures.
        parts: levels by body part.
        spots: actuators.
    """
    unit = height / HEIGHT
    x, y = corner
    for number, view in enumerate(VIEWS):
        middle = x + (2 * number + 1) * HALF_WIDTH * unit
        left = 1.0 if view == "front" else -1.0  # the side of its left hand
        for limb in figure(view):
            colour = colour_of(parts[limb.part]) if limb.part in parts else _ABSENT
            ends = np.array([limb.start, limb.end]) * unit + (middle, y)
            start, end = ends.tolist()
            builder.line(start, end, colour, limb.width * unit)
            edge = 0.3 * limb.width * unit
            low, high = ends.min(axis=0) - edge, ends.max(axis=0) + edge
            for spot in (one for one in spots if one.part == limb.part):
                share = 0.5 + left * (0.5 - spot.across), 1.0 - spot.down
                at = (low + share * (high - low)).tolist()
                builder.line(at, at, (*_WHITE[:3], 0.25 + 0.75 * spot.amplitude), 2.5)
        words = ui_text(view)
        width = builder.width(words, SMALL_TEXT)
        builder.text(words, (middle - width / 2, y + HEIGHT * unit + 6), FAINT_INK, SMALL_TEXT)
        for side, place in (("L", left), ("R", -left)):
            at = middle + place * 0.52 * unit - 3, y + 0.06 * unit
            builder.text(side, at, FAINT_INK, SMALL_TEXT)
