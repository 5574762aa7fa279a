"""Texts fitted to the width of the sidebar and the size of the user interface."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import bpy
from bpy.types import UILayout

from ...core.scene.choices import SourceKind
from ..blender.text import ELLIPSIS, shortened, text_width
from ..blender.words import show

if TYPE_CHECKING:
    from ...core.scene.values import Source

_WIDTH = 200.0
"""Width of a panel's content [points] at the default width of the sidebar, also used without a
sidebar."""
_BORDERS = {"UI": 66.0, "WINDOW": 48.0}
"""Width of the tabs of a sidebar, the scroll bar and the edges of a box [points], by region."""
ICON = 24.0
_BUTTON = 16.0  # points that a button needs beside its text


def draw_sentence(layout: UILayout, text: str, icon: str = "NONE") -> None:
    """Draw a sentence in as many lines as necessary."""
    column = layout.column(align=True)
    column.scale_y = 0.85
    draw_lines(column, text, icon)


def draw_lines(layout: UILayout, text: str, icon: str = "NONE", most: int = 99) -> int:
    """Draw a text in at most ``most`` lines. Returns their number."""
    width = content_width() - (ICON if icon != "NONE" else 0.0)
    parts = (text[:1].upper() + text[1:]).split("\n")
    found = [line for part in parts for line in lines(part, width)]
    if len(found) > most:
        found[most - 1 :] = [found[most - 1] + ELLIPSIS]
    for number, line in enumerate(found):
        show(layout, line, icon if number == 0 or icon == "NONE" else "BLANK1")
    return len(found)


def fitted(text: str, share: float = 1.0, icon: bool = False, button: bool = False) -> str:
    """A text for a ``share`` of the panel's width, shortened in the middle if it is longer."""
    return shortened_to(text, content_width() * share - ICON * icon - _BUTTON * button)


def shortened_to(text: str, width: float) -> str:
    """A text of at most ``width`` points, shortened in the middle if it is longer."""
    return shortened(text, width, font_size(), text_width) or text


def source_title(source: Source, share: float = 1.0) -> str:
    """A source's name for a ``share`` of the panel's width; for an impact both objects, each
    shortened separately."""
    if source.kind is not SourceKind.TEMPORARY or source.second_object is None:
        return fitted(source.name, share, icon=True, button=True)
    first, second = (
        fitted(name, (share - 0.06) / 2, button=True)
        for name in (source.object, source.second_object)
    )
    return f"{first} \N{MULTIPLICATION SIGN} {second}"


def content_width() -> float:
    """Width of a panel's content in points."""
    region = bpy.context.region
    if region is None or region.type not in _BORDERS:
        return _WIDTH
    return region.width / ui_scale() - _BORDERS[region.type]


@lru_cache(maxsize=512)
def _lines(text: str, width: float, size: float) -> tuple[str, ...]:
    found: list[str] = []
    for word in text.split():
        joined = f"{found[-1]} {word}" if found else word
        if found and text_width(joined, size) > width:
            found.append(word)
        else:
            found[-1:] = [joined]
    return tuple(found)


def lines(text: str, width: float) -> tuple[str, ...]:
    """A text broken between words into lines of at most ``width`` points; a longer word has a line
    of its own."""
    return _lines(text, width, font_size())


def font_size() -> float:
    """Size of texts in panels at a user interface scale of 1."""
    return float(bpy.context.preferences.ui_styles[0].widget.points)


def ui_scale() -> float:
    """Pixels per point of the user interface."""
    return bpy.context.preferences.system.ui_scale or 1.0  # 0 where there is no window
