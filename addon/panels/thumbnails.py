"""Small pictures in menus, each over the button that applies what it shows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bpy.types import UILayout
from bpy.utils import previews

from ..changes.events import disabled

_FOLDER = Path(__file__).parents[1] / "thumbnails"
_SCALE = 3.0  # lines high

_loaded: list[Any] = []


def cell(flow: UILayout, name: str) -> UILayout:
    """A column in a flow of columns that begins with the picture ``name`` ("material-steel")."""
    if not _loaded:
        _loaded.append(previews.new())
    picture = _loaded[0].get(name) or _loaded[0].load(name, str(_FOLDER / f"{name}.png"), "IMAGE")
    tuple(picture.image_size)  # loads it now: a menu is not drawn again when it has been loaded later
    column = flow.column(align=True)
    column.template_icon(icon_value=picture.icon_id, scale=_SCALE)
    return column


def forget() -> None:
    """Free the pictures."""
    while _loaded:
        previews.remove(_loaded.pop())


disabled.subscribe(forget)
