"""The shortcut that switches tracing on and off, and all of the add-on's shortcuts in its preferences."""

from __future__ import annotations

import bpy
from bpy.types import Context, UILayout

_items: list[tuple[bpy.types.KeyMap, bpy.types.KeyMapItem]] = []
_KEYMAPS = ("3D View", "Screen")


def draw(layout: UILayout, context: Context) -> None:
    """The add-on's shortcuts, where the user can change them."""
    import rna_keymap_ui

    configuration = context.window_manager.keyconfigs.user
    column = layout.column()
    column.label(text="Shortcuts")
    for name in _KEYMAPS:
        keymap = configuration.keymaps.get(name) if configuration is not None else None
        for item in keymap.keymap_items if keymap is not None else ():
            if item.idname.startswith("haptic."):
                column.context_pointer_set("keymap", keymap)
                rna_keymap_ui.draw_kmi([], configuration, keymap, item, column, 0)


def register() -> None:
    configuration = bpy.context.window_manager.keyconfigs.addon
    if configuration is None:  # in the background
        return
    keymap = configuration.keymaps.new(name="3D View", space_type="VIEW_3D")
    _items.append((keymap, keymap.keymap_items.new("haptic.toggle_tracing", "T", "PRESS", ctrl=True, shift=True, alt=True)))


def unregister() -> None:
    for keymap, item in _items:
        keymap.keymap_items.remove(item)
    _items.clear()
