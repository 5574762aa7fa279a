"""The meters as shapes and texts in pixels: a bar per listener, the scope of one, the body. No GPU."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from bpy.app.translations import pgettext_iface as iface_

from ...core.arrays import FloatArray, IntArray
from .annotations import FAINT_INK, INK, PLATE, TEXT_SIZE, Board, Furniture, Measure
from .body_map import HALF_WIDTH, HEIGHT, View, figure
from .colour_map import colour_table
from .levels import FLOOR, Level, decibels, place_of
from .render_data import SOURCE_COLOUR

Colour = tuple[float, ...]

# Points at a user interface scale of 1.
PADDING, GAP = 10.0, 8.0
ROW, BAR = 17.0, 9.0
NAME_WIDTH, BAR_WIDTH, LEVEL_WIDTH, FEELING_WIDTH = 112.0, 150.0, 44.0, 66.0
LEAST_BAR_WIDTH = 60.0
SCOPE_HEIGHT = 58.0
FIGURE_HEIGHT = (140.0, 200.0)  # as high as the rest, within these
MOST_ROWS = 12
_SCOPE_COLUMNS = 160
_CAPTION = 14.0  # points of the scope's height

_TRACK = (0.20, 0.20, 0.22, 1.0)
_ABSENT = (0.26, 0.26, 0.28, 1.0)
_SILENT = (0.42, 0.42, 0.44, 1.0)
_WHITE = (0.97, 0.97, 0.97, 1.0)
_MARK = (*SOURCE_COLOUR.tolist(), 1.0)
_GRID = (0.32, 0.32, 0.34, 1.0)
SCOPE_COLOUR: Colour = (*colour_table()[len(colour_table()) * 3 // 5].tolist(), 1.0)


@dataclass(frozen=True, slots=True)
class Scope:
    """The last second of a listener: ``samples`` (n,), fewer than a second's at the beginning."""

    listener: str
    samples: FloatArray
    sample_rate: float


def colour_of(level: Level) -> Colour:
    """By RMS level, grey where nothing is felt."""
    if not level.is_felt:
        return _SILENT
    return (*colour_table()[round(level.place * (len(colour_table()) - 1))].tolist(), 1.0)


@dataclass(frozen=True, slots=True)
class _Columns:
    """Widths in points: names, bars, decibels, and in words how that feels (0: no room for these)."""

    name: float
    bar: float
    level: float
    feeling: float

    @property
    def width(self) -> float:
        return self.name + self.bar + self.level + self.feeling

    @classmethod
    def within(cls, across: float, names: float, words: bool) -> _Columns | None:
        """What ``across`` points allow where the longest name takes ``names``; None where that is too little."""
        name, feeling = min(names + 8.0, NAME_WIDTH), FEELING_WIDTH if words else 0.0
        bar = min(across - name - LEVEL_WIDTH - feeling, BAR_WIDTH)
        return cls(name, bar, LEVEL_WIDTH, feeling) if bar >= (1.6 if words else 1.0) * LEAST_BAR_WIDTH else None


def meters(
    levels: Sequence[Level],
    scope: Scope | None,
    corner: tuple[float, float],
    room: tuple[float, float],
    scale: float,
    measure: Measure,
    *,
    title: str = "",
    body: bool = True,
) -> Furniture:
    """The meters, their lower left corner at ``corner`` [pixels], within ``room`` [pixels]. What has no room is left out: the words,
    the body, the scope, then listeners. ``scale``: pixels per point."""
    board = Board(scale)
    across, up = (side / scale - 2 * PADDING for side in room)
    below = SCOPE_HEIGHT + GAP if scope is not None and up >= SCOPE_HEIGHT + GAP + 4 * ROW else 0.0
    most = min(int((up - ROW - below) / ROW), MOST_ROWS)
    if most < min(len(levels), 2) or not levels:
        return board.furniture()
    shown = list(levels) if len(levels) <= most else _strongest(levels, most - 1)
    rows = len(shown) + (len(shown) < len(levels))
    parts = {level.body_part: level for level in levels if level.body_part}
    figure_height = min(max(rows * ROW + below - GAP, FIGURE_HEIGHT[0]), FIGURE_HEIGHT[1])
    figure_width = 4 * figure_height / HEIGHT * HALF_WIDTH
    body = body and bool(parts) and figure_height + ROW <= up
    names = max(measure(level.listener, TEXT_SIZE * scale) for level in shown) / scale
    wanted = ((True, body), (False, body), (True, False), (False, False))
    found = ((_Columns.within(across - (figure_width + GAP) * with_body, names, words), with_body) for words, with_body in wanted)
    columns, body = next((item for item in found if item[0] is not None), (None, False))
    if columns is None:
        return board.furniture()
    height = max(rows * ROW + below, figure_height if body else 0.0) + ROW + 2 * PADDING
    width = columns.width + 2 * PADDING + (figure_width + GAP if body else 0.0)
    left, bottom = corner
    board.plate(corner, (left + width * scale, bottom + height * scale), PLATE, 6.0)
    x, top = left + PADDING * scale, bottom + (height - PADDING) * scale
    _add_heads(board, (x, top), title, columns, measure)
    for number, level in enumerate(shown):
        _add_row(board, (x, top - (number + 2) * ROW * scale), level, columns, measure)
    if len(shown) < len(levels):
        board.text(iface_("and {} more").format(len(levels) - len(shown)), (x, top - (len(shown) + 2) * ROW * scale + 4 * scale), FAINT_INK)
    if below and scope is not None:
        _add_scope(board, (x, bottom + PADDING * scale), columns.width * scale, scope, measure)
    if body:
        y = bottom + (PADDING + (height - 2 * PADDING - ROW - figure_height) / 2) * scale
        _add_body(board, (x + (columns.width + GAP) * scale, y), figure_height, parts, measure)
    return board.furniture()


def _strongest(levels: Sequence[Level], most: int) -> list[Level]:
    """The strongest ones, in their order."""
    chosen = sorted(range(len(levels)), key=lambda k: -levels[k].rms)[:most]
    return [levels[k] for k in sorted(chosen)]


def _add_heads(board: Board, corner: tuple[float, float], title: str, columns: _Columns, measure: Measure) -> None:
    """The title, and the scale of the bars."""
    scale, size = board.scale, TEXT_SIZE * 0.86
    x, top = corner
    board.text(_fitted(title, (columns.name - 6) * scale, scale, measure), (x, top - 12 * scale), INK)
    left, width = x + columns.name * scale, (columns.bar - 8) * scale
    for tick in (-60, -40, -20, 0) if columns.bar > 110 else (-60, 0):
        words = f"\N{MINUS SIGN}{-tick}" if tick else "0 dB"
        half = measure(words, size * scale) / 2
        place = min(max(left + place_of(tick) * width - half, left), left + width - half)
        board.text(words, (place, top - 12 * scale), FAINT_INK, size)


def _add_row(board: Board, corner: tuple[float, float], level: Level, columns: _Columns, measure: Measure) -> None:
    """Name, bar and values of a listener. The bar is the RMS level, the white mark the peak, the orange one the threshold of feeling."""
    scale = board.scale
    x, y = corner
    base = y + 4 * scale
    board.text(_fitted(level.listener, (columns.name - 6) * scale, scale, measure), (x, base), INK)
    left, width = x + columns.name * scale, (columns.bar - 8) * scale
    low, high = y + (ROW - BAR) / 2 * scale, y + (ROW + BAR) / 2 * scale
    board.plate((left, low), (left + width, high), _TRACK, 2.0)
    if level.place > 0.01:
        board.plate((left, low), (left + level.place * width, high), colour_of(level), 2.0)
    if level.threshold is not None and FLOOR < level.threshold < 0:
        place = left + place_of(level.threshold) * width
        board.plate((place - 0.8 * scale, low - 2 * scale), (place + 0.8 * scale, high + 2 * scale), _MARK, 0.0)
    if level.peak > FLOOR:
        place = left + place_of(level.peak) * width
        board.plate((place - 1.0 * scale, low), (place + 1.0 * scale, high), _WHITE, 0.0)
    values = left + columns.bar * scale
    if columns.level:
        board.text(decibels(level.rms), (values, base), INK)
    if columns.feeling:
        board.text(level.feeling(), (values + columns.level * scale, base), FAINT_INK, TEXT_SIZE * 0.86)


def _fitted(words: str, width: float, scale: float, measure: Measure) -> str:
    """As much of a text as fits."""
    if measure(words, TEXT_SIZE * scale) <= width:
        return words
    for count in range(len(words) - 1, 0, -1):
        if measure(words[:count] + "…", TEXT_SIZE * scale) <= width:
            return words[:count] + "…"
    return ""


def _add_scope(board: Board, corner: tuple[float, float], width: float, scope: Scope, measure: Measure) -> None:
    """The last second: for every column the range between its lowest and highest sample, the latest at the right."""
    scale = board.scale
    left, low = corner
    high = low + SCOPE_HEIGHT * scale
    top = high - _CAPTION * scale
    middle, half = (low + top) / 2, (top - low) / 2 - 2 * scale
    board.plate((left, low), (left + width, high), _TRACK, 3.0)
    for quarter in (0.25, 0.5, 0.75):
        x = left + quarter * width
        board.plate((x - 0.5, low), (x + 0.5, top), _GRID, 0.0)
    board.plate((left, middle - 0.5), (left + width, middle + 0.5), _GRID, 0.0)
    full = full_scale(scope)
    columns, least, greatest = spans(scope, _SCOPE_COLUMNS)
    lows, highs = middle + half / full * least - 0.5 * scale, middle + half / full * greatest + 0.5 * scale
    for x, low_end, high_end in zip((left + columns * width / _SCOPE_COLUMNS).tolist(), lows.tolist(), highs.tolist(), strict=True):
        board.plate((x, low_end), (x + width / _SCOPE_COLUMNS, high_end), SCOPE_COLOUR, 0.0)
    size = TEXT_SIZE * 0.86
    board.text(iface_("{}, last second").format(scope.listener), (left + 5 * scale, high - 11 * scale), FAINT_INK, size)
    words = f"±{full:.3g}"
    board.text(words, (left + width - measure(words, size * scale) - 5 * scale, high - 11 * scale), FAINT_INK, size)


def full_scale(scope: Scope) -> float:
    """What the edge of the scope stands for: the next of 1, 0.316, 0.1, ... above the peak, at least 0.001."""
    peak = float(np.abs(scope.samples).max(initial=0.0))
    return 10 ** (math.ceil(math.log10(peak) * 2 - 1e-9) / 2) if peak > 1e-3 else 1e-3


def spans(scope: Scope, count: int) -> tuple[IntArray, FloatArray, FloatArray]:
    """The last second cut into ``count`` columns: the numbers of those that there is something of, their lowest and highest samples."""
    whole = round(scope.sample_rate)
    samples = scope.samples[-whole:]
    borders = np.round(np.linspace(0, whole, count + 1)).astype(np.int64) - (whole - len(samples))
    filled = np.flatnonzero(borders[:-1] >= 0)
    if not len(filled) or not len(samples):
        return np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros(0)
    starts = borders[filled]
    return filled, np.minimum.reduceat(samples, starts), np.maximum.reduceat(samples, starts)


def _add_body(board: Board, corner: tuple[float, float], height: float, parts: dict[str, Level], measure: Measure) -> None:
    """Two figures of ``height`` points, from the front and from behind; parts with a listener light up."""
    scale, size = board.scale, TEXT_SIZE * 0.86
    unit = height / HEIGHT * scale
    x, y = corner
    views: tuple[View, ...] = ("front", "back")
    for number, view in enumerate(views):
        middle = x + (2 * number + 1) * HALF_WIDTH * unit
        for limb in figure(view):
            colour = colour_of(parts[limb.part]) if limb.part in parts else _ABSENT
            ends = [(middle + place[0] * unit, y + place[1] * unit) for place in (limb.start, limb.end)]
            board.line(*ends, colour, limb.width * unit / scale)
        words = iface_(view)
        width = measure(words, size * scale)
        board.text(words, (middle - width / 2, y + HEIGHT * unit + 6 * scale), FAINT_INK, size)
        for side, place in (("L", 1.0 if view == "front" else -1.0), ("R", -1.0 if view == "front" else 1.0)):
            board.text(side, (middle + place * 0.52 * unit - 3 * scale, y + 0.06 * unit), FAINT_INK, size)
