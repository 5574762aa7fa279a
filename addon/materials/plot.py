"""The gain over distance as a picture in the panel, drawn again only where what it shows has changed."""

from __future__ import annotations

from typing import Any

import numpy as np
from bpy.types import Context
from numpy.typing import NDArray

from ...core.functions.curve import Curve

Pixels = NDArray[np.float32]
Colour = tuple[float, float, float]

SIZE = 256
FLOOR = -60.0
"""Decibels at the bottom of the picture."""

_MARGIN = 10
_KEY = "gain"

_previews: Any = None
_shown: object = None


def picture(curve: Curve, colour: Colour, ink: Colour) -> Pixels:
    """The curve as pixels (SIZE, SIZE, 4), colours times opacity, the first row at the bottom: from `FLOOR` to 0 dB upwards, the curve's
    reach across.

    Lines every 20 dB and at quarters of the reach, in ``ink``; the curve in ``colour``, filled below; the lowest and the highest band as
    thin lines.
    """
    pixels = np.zeros((SIZE, SIZE, 4), dtype=np.float32)
    inside = slice(_MARGIN, SIZE - _MARGIN)
    for part in np.linspace(0, 1, 4):
        _tint(pixels[_place(part), inside], ink, 0.5 if part == 0 else 0.2)
    for part in np.linspace(0, 1, 5):
        _tint(pixels[inside, _place(part)], ink, 0.5 if part == 0 else 0.2)
    columns = np.arange(_MARGIN, SIZE - _MARGIN)
    at = np.linspace(0, curve.reach, len(columns))
    for gains, width, filled in _lines(curve):
        decibels = 20 * np.log10(np.maximum(np.interp(at, curve.distances, gains), 1e-9))
        heights = _MARGIN + np.clip(1 - decibels / FLOOR, -0.02, 1) * (SIZE - 2 * _MARGIN - 1)
        _draw(pixels, columns, heights, colour, width, filled)
    return pixels


def _tint(pixels: Pixels, colour: Colour, alpha: float | NDArray[np.float64]) -> None:
    """Lay a colour over pixels (..., 4) whose colours are times their opacity."""
    cover = np.broadcast_to(np.asarray(alpha, dtype=np.float32), pixels.shape[:-1])[..., None]
    pixels *= 1 - cover
    pixels += cover * np.array([*colour, 1.0], dtype=np.float32)


def _lines(curve: Curve) -> list[tuple[NDArray[np.float64], float, bool]]:
    bands = [] if curve.bands is None else [(gains, 0.7, False) for gains in curve.bands]
    return [(curve.gains, 1.6, True), *bands]


def _place(part: float) -> int:
    return _MARGIN + round(part * (SIZE - 2 * _MARGIN - 1))


def _draw(pixels: Pixels, columns: NDArray[np.int64], heights: NDArray[np.float64], colour: Colour, width: float, filled: bool) -> None:
    """A smooth line over ``columns``; where it is steep it covers all rows between a column and the next."""
    rows = np.arange(SIZE)[:, None]
    following = np.append(heights[1:], heights[-1])
    low, high = np.minimum(heights, following), np.maximum(heights, following)
    distance = np.maximum(np.maximum(low - rows, rows - high), 0.0)
    alpha = np.clip(width + 0.5 - distance, 0.0, 1.0)
    if filled:
        alpha = np.maximum(alpha, np.where((rows < heights) & (rows > _MARGIN), 0.22, 0.0))
    chosen = pixels[:, columns]
    _tint(chosen, colour, alpha)
    pixels[:, columns] = chosen


def icon(key: object, curve: Curve, colour: Colour, ink: Colour) -> int:
    """The number of the icon that shows the curve; ``key`` says what it is drawn from, so that the same is not drawn twice."""
    global _previews, _shown
    from bpy.utils import previews

    if _previews is None:
        _previews = previews.new()
        _previews.new(_KEY).image_size = (SIZE, SIZE)
        _shown = None
    preview = _previews[_KEY]
    if _shown != (key, colour, ink):
        preview.image_pixels_float.foreach_set(picture(curve, colour, ink).ravel())
        _shown = (key, colour, ink)
    return preview.icon_id


def forget() -> None:
    """Free the picture."""
    global _previews, _shown
    if _previews is not None:
        from bpy.utils import previews

        previews.remove(_previews)
        _previews, _shown = None, None


def theme_ink(context: Context) -> Colour:
    """The colour of text in the theme in use."""
    return tuple(context.preferences.themes[0].user_interface.wcol_regular.text)
