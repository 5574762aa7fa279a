"""Pictures in panels, as icons that are redrawn when their content changes."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any

import numpy as np
from bpy.types import Context
from bpy.utils import previews
from numpy.typing import NDArray

from ..changes.events import disabled
from ..session.derived import Background
from .hud import TEXT_SIZE, HudBuilder
from .painting import paint

Pixels = NDArray[np.float32]
Colour = tuple[float, float, float]

SIZE = 256
"""Width and height of a picture in pixels; icons in panels are square."""


class Picture:
    """A picture in a panel, drawn on the worker thread. Its pixels (SIZE, SIZE, 4) are
    premultiplied, the first row at the bottom."""

    def __init__(self) -> None:
        self._previews: Any = None
        self._pixels: Background[Pixels] = Background()
        self._shown: Pixels | None = None
        disabled.subscribe(self.forget)

    def icon(self, key: Hashable, draw: Callable[[], Pixels]) -> int:
        """The identifier of the icon with the last picture; if ``key`` has changed, ``draw`` makes
        a new one."""
        if self._previews is None:
            self._previews = previews.new()
            self._previews.new("picture").image_size = SIZE, SIZE
            self._shown = None
        preview = self._previews["picture"]
        latest = self._pixels.latest(key, lambda before: draw())
        if latest is not None and latest.value is not self._shown:
            preview.image_pixels_float.foreach_set(latest.value.ravel())
            self._shown = latest.value
        return preview.icon_id

    def forget(self) -> None:
        """Free the picture; the next `icon` makes it again."""
        if self._previews is not None:
            previews.remove(self._previews)
            self._previews = None
            self._shown = None
            self._pixels = Background()


class Canvas(HudBuilder):
    """A layout of `SIZE` points, drawn without its texts and symbols: Blender measures texts on its
    main thread only."""

    def __init__(self) -> None:
        super().__init__(1.0)

    def width(self, words: str, size: float = TEXT_SIZE) -> float:
        return 0.0

    def painted(self) -> Pixels:
        """The plates and lines as pixels."""
        pixels = np.zeros((SIZE, SIZE, 4), dtype=np.float32)
        paint(pixels, self.build().lines)
        return pixels


def theme_ink(context: Context) -> Colour:
    """The colour of text in the theme in use."""
    return tuple(context.preferences.themes[0].user_interface.wcol_regular.text)
