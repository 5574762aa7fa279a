"""Painting of labels and legend into an array of pixels without a GPU: the shapes of `shader`,
texts by the outlines of Blender's font."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from bpy.types import VectorFont

from ..addon.blender.text import text_width
from ..addon.view.hud import Hud, PlacedText
from ..addon.view.render_data import Symbol
from ..addon.view.solids import layers
from ..core.arrays import BoolArray, FloatArray

_FINE = 4  # each pixel of a text is 4 x 4 samples
_WEIGHT = 0.75  # makes thin strokes as dark as Blender's own, which are hinted
_STEPS = 4  # lines per piece of a curve

Canvas = FloatArray
"""(height, width, 3) display values, bottom row first."""


def paint(canvas: Canvas, items: Hud, scale: float) -> None:
    """Paint ``items`` over ``canvas``. ``scale``: pixels per point."""
    lines = items.lines
    for (start, end), colour, width, shape in zip(
        lines.position, lines.colour, lines.width, lines.shape, strict=True
    ):
        if shape == Symbol.PLATE:
            _paint_plate(canvas, start[:2], end[:2], colour, width * scale / 2)
        elif shape == Symbol.LINE:
            _paint_line(canvas, start[:2], end[:2], colour[0], width * scale / 2)
        else:
            symbol = Symbol(int(shape))
            _paint_symbol(canvas, start[:2], colour[0, :3], width * scale / 2, symbol, scale)
    for text in items.texts:
        _paint_text(canvas, text)


def _paint_plate(
    canvas: Canvas, low: FloatArray, high: FloatArray, colour: FloatArray, radius: float
) -> None:
    def distance(x: FloatArray, y: FloatArray) -> FloatArray:
        across = np.abs(x - (low[0] + high[0]) / 2) - (high[0] - low[0]) / 2 + radius
        up = np.abs(y - (low[1] + high[1]) / 2) - (high[1] - low[1]) / 2 + radius
        return (
            np.hypot(np.maximum(across, 0), np.maximum(up, 0))
            + np.minimum(np.maximum(across, up), 0)
            - radius
        )

    def shade(x: FloatArray, y: FloatArray) -> FloatArray:
        part = np.clip((x - low[0]) / max(high[0] - low[0], 1e-9), 0, 1)
        return colour[0, :3] * (1 - part)[..., None] + colour[1, :3] * part[..., None]

    _fill(canvas, low - 1, high + 1, distance, shade, float(colour[0, 3]))


def _paint_line(
    canvas: Canvas, start: FloatArray, end: FloatArray, colour: FloatArray, radius: float
) -> None:
    along = end - start
    squared = max(float(along @ along), 1e-12)

    def distance(x: FloatArray, y: FloatArray) -> FloatArray:
        t = np.clip(((x - start[0]) * along[0] + (y - start[1]) * along[1]) / squared, 0, 1)
        return np.hypot(x - start[0] - t * along[0], y - start[1] - t * along[1]) - radius

    reach = radius + 1
    _fill(
        canvas,
        np.minimum(start, end) - reach,
        np.maximum(start, end) + reach,
        distance,
        colour[:3],
        float(colour[3]),
    )


def _paint_symbol(
    canvas: Canvas,
    centre: FloatArray,
    colour: FloatArray,
    radius: float,
    shape: Symbol,
    scale: float,
) -> None:
    for inset, layer, opacity in layers(shape, colour):
        inner = radius - inset * scale
        if inner <= 0:
            continue

        def distance(x: FloatArray, y: FloatArray, inner: float = inner) -> FloatArray:
            return _DISTANCES[shape](x - centre[0], y - centre[1], inner)

        _fill(canvas, centre - radius - 1, centre + radius + 1, distance, layer, opacity)


def _disc(x: FloatArray, y: FloatArray, radius: float) -> FloatArray:
    return np.hypot(x, y) - radius


def _diamond(x: FloatArray, y: FloatArray, radius: float) -> FloatArray:
    corner = 0.22 * radius
    x, y = np.abs(x), np.abs(y)
    return np.maximum(
        (x + y - radius + corner) * 0.70710678 - 0.29289 * corner, np.maximum(x, y) - radius
    )


def _burst(x: FloatArray, y: FloatArray, radius: float) -> FloatArray:
    ray = np.abs((np.arctan2(y, x) * 8 / (2 * np.pi)) % 1 - 0.5) * 2
    return (np.hypot(x, y) - radius * (0.55 + 0.45 * ray)) * 0.8


_DISTANCES: dict[Symbol, Callable[[FloatArray, FloatArray, float], FloatArray]] = {
    Symbol.CONTACT: _disc,
    Symbol.SOURCE: _disc,
    Symbol.IMPACT: _burst,
    Symbol.LISTENER: _diamond,
}


def _fill(
    canvas: Canvas,
    low: FloatArray,
    high: FloatArray,
    distance: Callable[[FloatArray, FloatArray], FloatArray],
    colour: FloatArray | Callable[[FloatArray, FloatArray], FloatArray],
    opacity: float,
) -> None:
    """Paint a shape given by its signed ``distance`` [pixels, negative inside], within the corners
    ``low`` and ``high``."""
    (left, bottom), (right, top) = (
        np.maximum(np.floor(low), 0).astype(int),
        np.ceil(high).astype(int),
    )
    part = canvas[bottom:top, left:right]
    y, x = np.mgrid[bottom : bottom + part.shape[0], left : left + part.shape[1]] + 0.5
    cover = (opacity * np.clip(0.5 - distance(x, y), 0, 1))[..., None]
    part += cover * ((colour(x, y) if callable(colour) else colour) - part)


def _paint_text(canvas: Canvas, text: PlacedText) -> None:
    edges, width = _outline(text.words)
    if not len(edges):
        return
    placed = edges * (text_width(text.words, text.size) / width) + text.position
    low = np.maximum(np.floor(placed.min(axis=(0, 1))) - 1, 0).astype(int)
    high = np.ceil(placed.max(axis=(0, 1))).astype(int) + 1
    part = canvas[low[1] : high[1], low[0] : high[0]]
    inside = _wound((placed - low) * _FINE, (part.shape[0] * _FINE, part.shape[1] * _FINE))
    cover = (
        inside.reshape(part.shape[0], _FINE, part.shape[1], _FINE).mean(axis=(1, 3))[..., None]
        ** _WEIGHT
    )
    part += cover * (np.array(text.colour) - part)


def _wound(edges: FloatArray, shape: tuple[int, int]) -> BoolArray:
    """Samples (rows, columns) that closed outlines of directed ``edges`` (n, 2, 2) wind around;
    outlines may overlap.

    An edge that a sample's row crosses to the left of it adds or takes one turn, by its direction.
    """
    (x0, y0), (x1, y1) = edges[:, 0].T, edges[:, 1].T
    first = np.clip(np.ceil(np.minimum(y0, y1) - 0.5), 0, shape[0]).astype(int)
    last = np.clip(np.ceil(np.maximum(y0, y1) - 0.5), 0, shape[0]).astype(int)
    counts = last - first
    edge = np.repeat(np.arange(len(edges)), counts)
    row = np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts) + first[edge]
    part = (row + 0.5 - y0[edge]) / (y1 - y0)[edge]
    column = np.clip(np.ceil(x0[edge] + part * (x1 - x0)[edge] - 0.5), 0, shape[1]).astype(int)
    turns = np.zeros((shape[0], shape[1] + 1), dtype=np.int64)
    np.add.at(turns, (row, column), np.where(y1 > y0, 1, -1)[edge])
    return np.cumsum(turns, axis=1)[:, :-1] != 0


@cache
def _outline(words: str) -> tuple[FloatArray, float]:
    """Directed edges (n, 2, 2) of a text set from its origin, and its width, in the units of its
    outlines."""
    known = set(bpy.data.fonts)
    curve = bpy.data.curves.new("Haptic text", "FONT")
    curve.body, curve.font = words, _font()
    obj = bpy.data.objects.new("Haptic text", curve)
    try:
        outlines = obj.to_curve(bpy.context.evaluated_depsgraph_get())
        rings = [_flattened(spline.bezier_points) for spline in outlines.splines]
    finally:
        obj.to_curve_clear()
        bpy.data.objects.remove(obj)
        bpy.data.curves.remove(curve)
        for font in set(bpy.data.fonts) - known:
            bpy.data.fonts.remove(font)
    if not rings:
        return np.zeros((0, 2, 2)), 1.0
    edges = np.concatenate([np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in rings])
    return edges, float(np.ptp(edges[..., 0]))


def _flattened(points: Any) -> FloatArray:
    """Corners (n, 2) along a closed Bezier curve."""
    knot, before, after = (
        np.array([getattr(p, key)[:2] for p in points])
        for key in ("co", "handle_left", "handle_right")
    )
    end, arriving = np.roll(knot, -1, axis=0), np.roll(before, -1, axis=0)
    t = (np.arange(_STEPS) / _STEPS)[None, :, None]
    start, leaving, arriving, end = (part[:, None, :] for part in (knot, after, arriving, end))
    curve = (
        (1 - t) ** 3 * start
        + 3 * (1 - t) ** 2 * t * leaving
        + 3 * (1 - t) * t**2 * arriving
        + t**3 * end
    )
    return curve.reshape(-1, 2)


def _font() -> VectorFont:
    """The font of Blender's user interface."""
    return bpy.data.fonts.load(
        str(Path(bpy.utils.resource_path("LOCAL")) / "datafiles" / "fonts" / "Inter.woff2"),
        check_existing=True,
    )
