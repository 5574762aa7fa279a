"""Painting of labels and legend into an array of pixels without a GPU: texts by the outlines of
Blender's font."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from bpy.types import VectorFont

from ..addon.blender.text import text_width
from ..addon.view import painting
from ..addon.view.hud import Hud, PlacedText
from ..core.arrays import BoolArray, FloatArray

_FINE = 4  # each pixel of a text is 4 x 4 samples
_WEIGHT = 0.75  # makes thin strokes as dark as Blender's own, which are hinted
_STEPS = 4  # lines per piece of a curve


def paint(canvas: FloatArray, items: Hud, scale: float) -> None:
    """Paint ``items`` over a ``canvas`` (height, width, 3) of display values, bottom row first.
    ``scale``: pixels per point."""
    painting.paint(canvas, items.lines, scale)
    for text in items.texts:
        _paint_text(canvas, text)


def _paint_text(canvas: FloatArray, text: PlacedText) -> None:
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
