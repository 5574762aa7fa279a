"""The add-on's entries in Blender's own menus and headers, and in its manual."""

from __future__ import annotations

import bpy

from ..blender.documentation import manual_map
from ..panels import export, object_menus

_ENTRIES = (
    ("TOPBAR_MT_file_export", export.draw_export),
    ("TOPBAR_MT_file_import", export.draw_import),
    ("VIEW3D_MT_object", object_menus.draw_object_menu),
    ("VIEW3D_MT_add", object_menus.draw_add_menu),
)


def register() -> None:
    """Append the entries, and give F1 its pages."""
    for menu, entry in _ENTRIES:
        getattr(bpy.types, menu).append(entry)
    bpy.utils.register_manual_map(manual_map)


def unregister() -> None:
    """Remove them."""
    bpy.utils.unregister_manual_map(manual_map)
    for menu, entry in reversed(_ENTRIES):
        getattr(bpy.types, menu).remove(entry)
