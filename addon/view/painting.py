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
        lines.shape.astype(np.int64).tolist(),
        strict=True,
    ):
        (x0, y0), (x1, y1) = np.minimum(start, end), np.maximum(start, end)
        around = 1.0 if shape == Symbol.PLATE else radius + 1
        left, bottom = (max(math.floor(at - around), 0) for at in (x0, y0))
        last, top = (max(math.ceil(at + around), 0) for at in (x1, y1))
        part = canvas[bottom:top, left:last]
        y = np.arange(bottom, bottom + part.shape[0])[:, None] + 0.5
        x = np.arange(left, left + part.shape[1]) + 0.5
        if shape == Symbol.PLATE:
            right = np.abs(x - (x0 + x1) / 2) - (x1 - x0) / 2 + radius
            up = np.abs(y - (y0 + y1) / 2) - (y1 - y0) / 2 + radius
            outside = np.hypot(np.maximum(right, 0), np.maximum(up, 0))
            away = outside + np.minimum(np.maximum(right, up), 0) - radius
            share = np.clip((x - x0) / max(x1 - x0, 1e-9), 0, 1)[:, None]
            _cover(part, away, ends[0] + share * (ends[1] - ends[0]), opacity)
        elif shape == Symbol.LINE:
            way = end - start
            along = (x - start[0]) * way[0] + (y - start[1]) * way[1]
            share = np.clip(along / max(float(way @ way), 1e-12), 0, 1)
            away = np.hypot(x - start[0] - share * way[0], y - start[1] - share * way[1]) - radius
            _cover(part, away, ends[0], opacity)
        else:
            look = LOOKS[Symbol(shape)]
            outline = look.radius(np.arctan2(y - y0, x - x0))
            for inset, layer, cover in look.coloured(ends[0]):
                inner = max(radius - inset * scale, 0.0)
                away = np.hypot(x - x0, y - y0) - inner * outline
                _cover(part, away, layer, cover if inner else 0.0)


def _cover(
    part: FloatArray | Drawn, away: FloatArray, colour: FloatArray | Drawn, opacity: float
) -> None:
    """Paint a ``colour`` where the distance ``away`` to its edge [pixels] is negative."""
    part += (opacity * np.clip(0.5 - away, 0, 1))[..., None] * (colour - part)
