"""Labels and legend in pixels: plates, symbols and texts. No GPU; how wide a text is comes from outside."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import TypeVar

import numpy as np
from bpy.app.translations import pgettext_iface as iface_

from .colour_map import STEPS, FloatArray, GainScale, colour_table
from .label_placement import around, place_labels, project
from .render_data import IMPACT_COLOUR, SOURCE_COLOUR, Lines, Points, RenderData, Shape

TEXT_SIZE = 11.0
INK = (0.94, 0.94, 0.94)
FAINT_INK = (0.72, 0.72, 0.72)
PLATE = (0.075, 0.075, 0.085, 0.84)
_PADDING = (6.0, 4.0)
_GAP = 5.0  # points between a place's symbol and its label
_LEGEND = (18.0, 10.0, 10.0)  # points: a symbol, between two names, around everything
_MOST_STEPS, _MOST_LABELS = 150, 32  # all body parts, and some sources
NAMES = {Shape.SOURCE: "Source", Shape.IMPACT: "Impact", Shape.LISTENER: "Listener", Shape.CONTACT: "Contact"}

Part = TypeVar("Part", Lines, Points)

Rectangle = tuple[float, float, float, float]
"""Left, bottom, right, top in pixels."""
Measure = Callable[[str, float], float]
"""Width in pixels of a text at a size in pixels."""


@dataclass(frozen=True, slots=True)
class Text:
    """Words with the start of their baseline at ``position`` [pixels]."""

    words: str
    position: tuple[float, float]
    size: float
    colour: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Furniture:
    """What lies over the picture: ``lines`` and ``points`` in pixels (z = 0, sizes in points), and ``texts``."""

    lines: Lines
    points: Points
    texts: tuple[Text, ...]


class Board:
    """Collects plates, lines, symbols and texts. ``scale``: pixels per point."""

    def __init__(self, scale: float) -> None:
        self.scale = scale
        self.strokes: list[tuple[float, ...]] = []
        self.symbols: list[tuple[float, ...]] = []
        self.texts: list[Text] = []

    def plate(
        self, low: Sequence[float], high: Sequence[float], colour: Sequence[float], radius: float, right: Sequence[float] | None = None
    ) -> None:
        """``radius`` of the corners in points; ``right``: the colour at the right end where it is another."""
        self.strokes.append((*low, 0, *high, 0, *colour, *(colour if right is None else right), 2 * radius, Shape.PLATE))

    def line(self, start: Sequence[float], end: Sequence[float], colour: Sequence[float], width: float) -> None:
        """``width`` in points."""
        self.strokes.append((*start, 0, *end, 0, *colour, *colour, width, Shape.LINE))

    def symbol(self, centre: Sequence[float], shape: Shape, size: float, colour: Sequence[float]) -> None:
        self.symbols.append((*centre, 0, *colour, 1, size, shape))

    def text(self, words: str, position: Sequence[float], colour: Sequence[float], size: float = TEXT_SIZE) -> None:
        self.texts.append(Text(words, (float(position[0]), float(position[1])), size * self.scale, tuple(colour)))

    def furniture(self) -> Furniture:
        strokes = np.array(self.strokes, dtype=np.float32).reshape(-1, 16)
        symbols = np.array(self.symbols, dtype=np.float32).reshape(-1, 9)
        return Furniture(
            Lines(
                position=strokes[:, :6].reshape(-1, 2, 3),
                colour=strokes[:, 6:14].reshape(-1, 2, 4),
                width=strokes[:, 14],
                way=np.full((len(strokes), 2), -1, dtype=np.float32),
                shape=strokes[:, 15],
            ),
            Points(position=symbols[:, :3], colour=symbols[:, 3:7], size=symbols[:, 7], shape=symbols[:, 8]),
            tuple(self.texts),
        )


def furniture(
    data: RenderData,
    perspective: FloatArray,
    size: tuple[float, float],
    scale: float,
    free: Rectangle,
    measure: Measure,
    taken: Sequence[Rectangle] = (),
) -> Furniture:
    """Labels and legend for a viewport of ``size`` pixels, seen with ``perspective`` (4, 4). ``scale``: pixels per point.
    ``free``: what nothing else covers of the viewport; ``taken``: what is drawn within it already."""
    shapes = tuple(shape for shape in NAMES if (data.points.shape == shape).any())
    names = tuple(iface_(name) for name in NAMES.values())
    legend, place = _legend(data.scale, shapes, names, (free[2], free[1]), scale, measure)
    above = max((other[3] for other in taken if other[2] > place[0] and other[3] > place[1] and other[0] < place[2]), default=None)
    if above is not None:
        legend, place = _legend(data.scale, shapes, names, (free[2], above), scale, measure)
    board = Board(scale)
    if data.labels:
        _add_labels(board, data, perspective, size, free, np.array([place, *taken]), measure)
    labels = board.furniture()
    return Furniture(_joined(legend.lines, labels.lines), _joined(legend.points, labels.points), legend.texts + labels.texts)


def plate_of(board: Furniture | None) -> tuple[Rectangle, ...]:
    """What a board covers: its first plate."""
    return () if board is None else tuple((*low[:2], *high[:2]) for low, high in board.lines.position[:1].tolist())


def moved(items: Furniture, right: float, up: float) -> Furniture:
    """Everything some pixels further to the right and up."""
    by = np.array([right, up, 0], dtype=np.float32)
    return Furniture(
        replace(items.lines, position=items.lines.position + by),
        replace(items.points, position=items.points.position + by),
        tuple(replace(text, position=(text.position[0] + right, text.position[1] + up)) for text in items.texts),
    )


def _joined(first: Part, second: Part) -> Part:
    return type(first)(*(np.concatenate([getattr(first, f.name), getattr(second, f.name)]) for f in fields(first)))


def _add_labels(
    board: Board,
    data: RenderData,
    perspective: FloatArray,
    size: tuple[float, float],
    free: Rectangle,
    taken: FloatArray,
    measure: Measure,
) -> None:
    scale, text = board.scale, TEXT_SIZE * board.scale
    anchor = project(np.array([label.position for label in data.labels]), perspective, size)
    priority = np.where(np.isnan(anchor[:, 0]), -np.inf, [label.priority for label in data.labels])
    shown = np.argsort(-priority, kind="stable")[: min(_MOST_LABELS, np.isfinite(priority).sum())]
    labels, anchor = [data.labels[k] for k in shown.tolist()], anchor[shown]
    space = measure(" ", text) * 1.6
    names = np.array([measure(label.name, text) for label in labels])
    values = np.array([measure(label.value, text) for label in labels])
    extent = np.column_stack([names + space + values, np.full(len(labels), text * 0.95)]) + 2 * scale * np.array(_PADDING)
    clearance = scale * (np.array([label.clearance for label in labels]) + _GAP)
    symbols = data.points.shape != Shape.CONTACT
    places = project(data.points.position[symbols].astype(np.float64), perspective, size)
    taken = np.concatenate([taken, around(places, scale * data.points.size[symbols] / 2)])
    busy = project(_along_paths(data.paths), perspective, size)
    corner = place_labels(anchor, extent, clearance, free, taken, busy[~np.isnan(busy[:, 0])])
    corners, anchors, extents = np.round(corner).tolist(), anchor.tolist(), extent.tolist()
    for k in np.flatnonzero(~np.isnan(corner[:, 0])).tolist():
        label, (x, y), (left, bottom) = labels[k], anchors[k], corners[k]
        right, top = left + extents[k][0], bottom + extents[k][1]
        nearest = min(max(x, left), right), min(max(y, bottom), top)
        if math.dist(nearest, (x, y)) > clearance[k] + _GAP * scale:
            board.line((x, y), nearest, (*FAINT_INK, 0.8), 1.0)
        board.plate((left, bottom), (right, top), PLATE, 4.0)
        start, base = left + scale * _PADDING[0], bottom + scale * (_PADDING[1] + 1.2)
        board.text(label.name, (start, base), INK)
        board.text(label.value, (start + float(names[k]) + space, base), label.colour)


def _along_paths(lines: Lines) -> FloatArray:
    """Places (k, 3) along the best paths, which labels had better not cover."""
    ends = lines.position[-_MOST_STEPS:].astype(np.float64)
    part = np.linspace(0, 1, 12)[None, :, None]
    return (ends[:, :1] * (1 - part) + ends[:, 1:] * part).reshape(-1, 3)


def legend_width(scale: float, measure: Measure) -> float:
    """As wide as with all symbols, so that the legend stays where it is when there is an impact [pixels]."""
    symbol_width, gap, padding = (part * scale for part in _LEGEND)
    names = sum(measure(iface_(name), TEXT_SIZE * scale) for name in NAMES.values())
    return names + len(NAMES) * symbol_width + (len(NAMES) - 1) * gap + 2 * padding


@lru_cache(maxsize=8)
def _legend(
    gains: GainScale, shapes: tuple[Shape, ...], names: tuple[str, ...], corner: tuple[float, float], scale: float, measure: Measure
) -> tuple[Furniture, tuple[float, ...]]:
    """The legend, with its lower right corner a little away from ``corner``, and the rectangle that it takes. ``names``: of all shapes."""
    board, text = Board(scale), TEXT_SIZE * scale
    named = dict(zip(NAMES, names, strict=True))
    widths = [measure(named[shape], text) for shape in shapes]
    symbol_width, gap, padding = (part * scale for part in _LEGEND)
    width = legend_width(scale, measure)
    height = 66 * scale
    left, bottom = round(corner[0] - width - 12 * scale), round(corner[1] + 12 * scale)
    board.plate((left, bottom), (left + width, bottom + height), PLATE, 6.0)
    x, base = left + padding, bottom + height - 20 * scale
    for shape, text_width in zip(shapes, widths, strict=True):
        colour = {Shape.SOURCE: SOURCE_COLOUR, Shape.IMPACT: IMPACT_COLOUR}.get(shape, colour_table()[STEPS * 3 // 5])
        size = 8.0 if shape == Shape.CONTACT else 17.0
        board.symbol((x + symbol_width / 2 - 2 * scale, base + 4 * scale), shape, size, colour)
        board.text(named[shape], (x + symbol_width, base), INK)
        x += symbol_width + text_width + gap
    _add_bar(board, gains, left + padding, bottom + 24 * scale, width - 2 * padding, measure)
    return board.furniture(), (left, bottom, left + width, bottom + height)


def _add_bar(board: Board, gains: GainScale, left: float, bottom: float, width: float, measure: Measure) -> None:
    """The colours from the floor to 0 dB, with round values below."""
    scale, height, parts = board.scale, 10 * board.scale, 32
    for part in range(parts):
        # Each part reaches under the next one, so that no seam shows.
        low, high = part / parts, min((part + 2) / parts, 1.0)
        first, last = (colour_table()[round(place * (STEPS - 1))] for place in (low, high))
        board.plate((left + low * width, bottom), (left + high * width, bottom + height), (*first, 1), 0.0, (*last, 1))
    size = TEXT_SIZE * 0.86
    for tick in gains.ticks():
        x = left + (1 - tick / gains.floor) * width
        board.plate((x - 0.5 * scale, bottom - 4 * scale), (x + 0.5 * scale, bottom), (*FAINT_INK, 1), 0.0)
        words = f"\N{MINUS SIGN}{-tick}" if tick else "0 dB"
        text_width = measure(words, size * scale)
        x = min(max(x - text_width / 2, left), left + width - text_width)
        board.text(words, (x, bottom - 14 * scale), FAINT_INK, size)
