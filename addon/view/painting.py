"""Painting of plates, lines and symbols into an array of pixels without a GPU: the shapes of
``quads.frag.glsl``."""

from __future__ import annotations

import math

import numpy as np

from ...core.arrays import FloatArray
from .render_data import Drawn, Lines
from .symbols import LOOKS, Symbol


def paint(canvas: FloatArray | Drawn, lines: Lines, scale: float = 1.0) -> None:
    """Paint ``lines`` over a ``canvas`` (height, width, 3 or 4) of display values, with
    premultiplied opacity if it has one, bottom row first. ``scale``: pixels per point."""
    colours = lines.colour.astype(canvas.dtype)
    colours[..., 3] = 1.0
    for (start, end), ends, opacity, radius, shape in zip(
        lines.position[:, :, :2].astype(np.float64),
        colours[..., : canvas.shape[2]],
        lines.colour[:, 0, 3].tolist(),
        (lines.width * scale / 2).tolist(),
        map(Symbol, lines.shape.astype(np.int64).tolist()),
        strict=True,
    ):
        around = 1.0 if shape is Symbol.PLATE else radius + 1
        left, bottom = (max(math.floor(at - around), 0) for at in np.minimum(start, end).tolist())
        right, top = (max(math.ceil(at + around), 0) for at in np.maximum(start, end).tolist())
        part = canvas[bottom:top, left:right]
        middle = (start + end) / 2
        x = np.arange(left, left + part.shape[1]) + 0.5 - middle[0]
        y = (np.arange(bottom, bottom + part.shape[0]) + 0.5 - middle[1])[:, None]
        if shape in LOOKS:
            outline = LOOKS[shape].radius(np.arctan2(y, x))
            for inset, layer, cover in LOOKS[shape].coloured(ends[0]):
                inner = max(radius - inset * scale, 0.0)
                _cover(part, np.hypot(x, y) - inner * outline, layer, cover if inner else 0.0)
            continue
        # A line is a plate with round ends, turned.
        way = end - start
        length = float(np.hypot(*way))
        half = np.array([length / 2, 0.0])
        if shape is Symbol.PLATE:
            half, length = np.abs(way) / 2 - radius, abs(float(way[0]))
        elif length:
            x, y = (x * way[0] + y * way[1]) / length, (y * way[0] - x * way[1]) / length
        beside, above = np.abs(x) - half[0], np.abs(y) - half[1]
        outside = np.hypot(np.maximum(beside, 0), np.maximum(above, 0))
        away = outside + np.minimum(np.maximum(beside, above), 0) - radius
        share = np.clip(x / max(length, 1e-9) + 0.5, 0, 1)[..., None]
        _cover(part, away, ends[0] + share * (ends[1] - ends[0]), opacity)


def _cover(
    part: FloatArray | Drawn, away: FloatArray, colour: FloatArray | Drawn, opacity: float
) -> None:
    """Paint a ``colour`` where the distance ``away`` to its edge [pixels] is negative."""
    part += (opacity * np.clip(0.5 - away, 0, 1))[..., None] * (colour - part)
