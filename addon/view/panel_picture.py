"""Pictures in panels: pixels as an icon, drawn again only where what they show has changed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from bpy.types import Context
from numpy.typing import NDArray

Pixels = NDArray[np.float32]
Colour = tuple[float, float, float]

SIZE = 256
"""Pixels of a picture's sides: panels give icons a square."""


class Picture:
    """A picture in a panel. Its pixels (SIZE, SIZE, 4) have colours times opacity, the first row at the bottom."""

    def __init__(self) -> None:
        self._previews: Any = None
        self._shown: object = None

    def icon(self, key: object, draw: Callable[[], Pixels]) -> int:
        """The number of the icon that shows what ``draw`` gives; ``key`` says what it is drawn from: the same is not drawn twice."""
        if self._previews is None:
            from bpy.utils import previews

            self._previews = previews.new()
            self._previews.new("picture").image_size = (SIZE, SIZE)
            self._shown = None
        preview = self._previews["picture"]
        if self._shown != key:
            preview.image_pixels_float.foreach_set(draw().ravel())
            self._shown = key
        return preview.icon_id

    def forget(self) -> None:
        """Free it; it is made again where it is asked for again."""
        if self._previews is not None:
            from bpy.utils import previews

            previews.remove(self._previews)
            self._previews, self._shown = None, None


def blank() -> Pixels:
    """A picture with nothing on it."""
    return np.zeros((SIZE, SIZE, 4), dtype=np.float32)


def tint(pixels: Pixels, colour: Colour, alpha: float | NDArray[Any]) -> None:
    """Lay a colour over pixels (..., 4), as opaque as ``alpha`` says, a number or (...)."""
    cover = np.broadcast_to(np.asarray(alpha, dtype=np.float32), pixels.shape[:-1])[..., None]
    pixels *= 1 - cover
    pixels += cover * np.array([*colour, 1.0], dtype=np.float32)


def theme_ink(context: Context) -> Colour:
    """The colour of text in the theme in use."""
    return tuple(context.preferences.themes[0].user_interface.wcol_regular.text)
