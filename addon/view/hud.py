"""Plates, symbols and texts over a viewport, in its pixels, independent of the GPU."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...core.frozen import frozen
from ..blender.text import shortened, text_width
from .render_data import Drawn, Lines, Place, joined, lines_of
from .symbols import Symbol

TEXT_SIZE = 11.0
SMALL_TEXT = 0.86 * TEXT_SIZE
INK = (0.94, 0.94, 0.94)
FAINT_INK = (0.72, 0.72, 0.72)
PLATE = (0.075, 0.075, 0.085, 0.84)
_DARKER = 0.55  # of coloured texts in a light theme

Rectangle = tuple[float, float, float, float]
"""Left, bottom, right, top in pixels."""


@frozen
class PlacedText:
    """A text with the start of its baseline at ``position`` [pixels]."""

    words: str
    position: Place
    size: float
    colour: tuple[float, float, float]


class Target(NamedTuple):
    """An area that can be clicked: a listener, and the letter of its switch there, "" for none."""

    area: Rectangle
    listener: str
    switch: str = ""


@frozen
class Hud:
    """Elements drawn over a viewport: ``lines``, with plates and symbols, in pixels (z = 0, sizes
    in points) and ``texts``; ``bounds``: the plates; ``targets``: the first one counts."""

    lines: Lines
    texts: tuple[PlacedText, ...]
    bounds: tuple[Rectangle, ...] = ()
    targets: tuple[Target, ...] = ()

    def moved(self, right: float, up: float) -> Hud:
        """A copy, moved to the ``right`` and ``up`` by so many pixels."""
        by = np.array([right, up, 0], dtype=np.float32)
        return Hud(
            replace(self.lines, position=self.lines.position + by),
            tuple(
                replace(text, position=(text.position[0] + right, text.position[1] + up))
                for text in self.texts
            ),
            tuple(_moved(bounds, right, up) for bounds in self.bounds),
            tuple(target._replace(area=_moved(target.area, right, up)) for target in self.targets),
        )

    def joined(self, other: Hud) -> Hud:
        """Both, ``other`` drawn over this one."""
        lines = joined(self.lines, other.lines)
        return Hud(lines, self.texts + other.texts, self.bounds + other.bounds)

    def on_light(self) -> Hud:
        """A copy for a light theme: greys inverted, texts of other colours darker."""
        colour = self.lines.colour.copy()
        colour[..., :3] = np.where(_is_grey(colour), 1 - colour[..., :3], colour[..., :3])
        texts = []
        for text in self.texts:
            ink = np.array(text.colour)
            ink = np.where(_is_grey(ink), 1 - ink, _DARKER * ink)
            texts.append(replace(text, colour=tuple(ink.tolist())))
        return replace(self, lines=replace(self.lines, colour=colour), texts=tuple(texts))


class HudBuilder:
    """Collects plates, lines, symbols and texts, all in points. ``scale``: pixels per point."""

    def __init__(self, scale: float) -> None:
        self.scale = scale
        self._strokes: list[tuple[float, ...]] = []
        self._texts: list[PlacedText] = []
        self._bounds: list[Rectangle] = []
        self._targets: list[Target] = []

    def width(self, words: str, size: float = TEXT_SIZE) -> float:
        """The width of a text of ``size`` points."""
        return text_width(words, size * self.scale) / self.scale

    def fitted(self, words: str, width: float, size: float = TEXT_SIZE) -> str:
        """A text of ``size`` points, shortened to at most ``width`` points."""
        return shortened(words, width, size, self.width)

    def panel(self, low: Sequence[float], high: Sequence[float], radius: float) -> None:
        """Add a plate under other elements; its area counts as covered."""
        self.plate(low, high, PLATE, radius)
        self._bounds.append((low[0], low[1], high[0], high[1]))

    def plate(
        self,
        low: Sequence[float],
        high: Sequence[float],
        colour: Sequence[float],
        radius: float,
        right: Sequence[float] | None = None,
    ) -> None:
        """Add a rectangle with rounded corners.

        Args:
            low: lower left corner.
            high: upper right corner.
            colour: RGBA.
            radius: of its corners.
            right: colour at its right end if that differs.
        """
        ends = *colour, *(colour if right is None else right)
        self._strokes.append((*low, 0, *high, 0, *ends, 2 * radius, Symbol.PLATE))

    def line(
        self, start: Sequence[float], end: Sequence[float], colour: Sequence[float], width: float
    ) -> None:
        """A line of a ``width``."""
        self._strokes.append((*start, 0, *end, 0, *colour, *colour, width, Symbol.LINE))

    def target(self, low: Place, high: Place, listener: str, switch: str = "") -> None:
        """Make an area clickable."""
        left, bottom, right, top = (float(end * self.scale) for end in (*low, *high))
        self._targets.append(Target((left, bottom, right, top), listener, switch))

    def symbol(
        self, centre: Sequence[float], shape: Symbol, size: float, colour: Sequence[float]
    ) -> None:
        """A symbol of a ``size``."""
        self._strokes.append((*centre, 0, *centre, 0, *colour, 1, *colour, 1, size, shape))

    def text(
        self,
        words: str,
        position: Sequence[float],
        colour: Sequence[float],
        size: float = TEXT_SIZE,
    ) -> None:
        """A text of a ``size``, the start of its baseline at ``position``."""
        x, y = (float(at * self.scale) for at in position)
        red, green, blue = colour[:3]
        self._texts.append(PlacedText(words, (x, y), size * self.scale, (red, green, blue)))

    def build(self) -> Hud:
        """Everything collected so far."""
        strokes = np.array(self._strokes, dtype=np.float64).reshape(-1, 16)
        position = strokes[:, :6].reshape(-1, 2, 3) * self.scale
        colour = strokes[:, 6:14].reshape(-1, 2, 4)
        lines = lines_of(
            position, colour[..., :3], colour[..., 3], strokes[:, 14], shape=strokes[:, 15]
        )
        bounds = (np.array(self._bounds).reshape(-1, 4) * self.scale).tolist()
        return Hud(lines, tuple(self._texts), tuple(map(tuple, bounds)), tuple(self._targets))


def _is_grey(colour: Drawn) -> Any:
    """Whether each colour (..., 3 or 4) is a grey (..., 1)."""
    return np.ptp(colour[..., :3], axis=-1, keepdims=True) < 0.05


def _moved(area: Rectangle, right: float, up: float) -> Rectangle:
    left, bottom, end, top = area
    return left + right, bottom + up, end + right, top + up


def overlaps(one: Rectangle, other: Rectangle) -> bool:
    """True where two rectangles share more than an edge."""
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]
