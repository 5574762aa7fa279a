"""Kinds of properties: switches, choices, texts, numbers and references, each with its name, its
tooltip and its default. All of them take further arguments of Blender's properties (``more``)."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

FRAMES = (-1048574, 1048574)
"""Blender's range of frames."""
_RELATIVE = {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5, 0) else set[str]()


def switch(name: str, description: str, default: bool = False, **more: Any) -> BoolProperty:
    """A property that is on or off."""
    return BoolProperty(name=name, description=description, default=default, **more)


def number(
    name: str, description: str, default: float, span: tuple[float, float], **more: Any
) -> FloatProperty:
    """A number from the beginning of ``span`` on; its slider ends with the span, beyond which a
    number can be typed."""
    return FloatProperty(
        name=name, description=description, default=default, min=span[0], soft_max=span[1], **more
    )


def limited(
    name: str, description: str, default: float, span: tuple[float, float], **more: Any
) -> FloatProperty:
    """A number within ``span``."""
    return FloatProperty(
        name=name, description=description, default=default, min=span[0], max=span[1], **more
    )


def share(name: str, description: str, default: float, **more: Any) -> FloatProperty:
    """A part of a whole, 0 to 1."""
    return limited(name, description, default, (0.0, 1.0), subtype="FACTOR", **more)


def choice(
    name: str, description: str, items: tuple[tuple[Any, ...], ...], **more: Any
) -> EnumProperty:
    """One of several items; the first unless ``more`` has a default."""
    return EnumProperty(name=name, description=description, items=items, **more)


def text(name: str, description: str, default: str = "", **more: Any) -> StringProperty:
    """A text, such as a name, a path or a formula."""
    return StringProperty(name=name, description=description, default=default, **more)


def file_path(name: str, description: str) -> StringProperty:
    """The path of a file, which may be relative to the .blend; see `io.stored_paths`."""
    return text(name, description, subtype="FILE_PATH", options=_RELATIVE)


def whole(
    name: str, description: str, default: int, span: tuple[int, int], **more: Any
) -> IntProperty:
    """A whole number within ``span``."""
    return IntProperty(
        name=name, description=description, default=default, min=span[0], max=span[1], **more
    )


def reference(kind: type, name: str, description: str, **more: Any) -> PointerProperty:
    """A datablock of Blender, such as an object."""
    return PointerProperty(type=kind, name=name, description=description, **more)
