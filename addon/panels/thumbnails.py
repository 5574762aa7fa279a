"""Thumbnails in menus, each above the button that applies its item."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bpy.types import UILayout
from bpy.utils import previews

from ..changes.events import disabled

_FOLDER = Path(__file__).parents[1] / "thumbnails"
_SCALE = 3.0  # lines high

_loaded: list[Any] = []


def cell(
    flow: UILayout, name: str, pixels: Sequence[float] = (), scale: float = _SCALE
) -> UILayout:
    """A column in a flow of columns that begins with the picture ``name`` ("material-steel"),
    ``scale`` lines high: a file, or a square of ``pixels`` (RGBA)."""
    if not _loaded:
        _loaded.append(previews.new())
    picture = _loaded[0].get(name)
    if picture is None and pixels:
        picture = _loaded[0].new(name)
        picture.image_size = (math.isqrt(len(pixels) // 4),) * 2
        picture.image_pixels_float = pixels
    picture = picture or _loaded[0].load(name, str(_FOLDER / f"{name}.png"), "IMAGE")
    # Loads it now, because a menu is not redrawn after asynchronous loading.
    tuple(picture.image_size)
    column = flow.column(align=True)
    column.template_icon(icon_value=picture.icon_id, scale=scale)
    return column


def forget() -> None:
    """Free the pictures."""
    while _loaded:
        previews.remove(_loaded.pop())


disabled.subscribe(forget)
