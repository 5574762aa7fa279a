"""The shortcuts that switch tracing on and off and choose the mode, and all of the add-on's shortcuts in its preferences."""

from __future__ import annotations

import bpy
from bpy.types import Context, KeyMap, KeyMapItem, UILayout

_items: list[tuple[KeyMap, KeyMapItem]] = []
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
            if is_own(item):
                column.context_pointer_set("keymap", keymap)
                rna_keymap_ui.draw_kmi([], configuration, keymap, item, column, 0)


def is_own(item: KeyMapItem) -> bool:
    """Whether a shortcut runs an operator of the add-on or opens one of its menus."""
    return item.idname.startswith("haptic.") or (
        item.idname == "wm.call_menu_pie" and item.properties is not None and item.properties.name.startswith("HAPTIC_")
    )


def register() -> None:
    configuration = bpy.context.window_manager.keyconfigs.addon
    if configuration is None:  # in the background
        return
    keymap = configuration.keymaps.new(name="3D View", space_type="VIEW_3D")
    for operator, key in (("haptic.toggle_tracing", "T"), ("wm.call_menu_pie", "M")):
        _items.append((keymap, keymap.keymap_items.new(operator, key, "PRESS", ctrl=True, shift=True, alt=True)))
    _items[-1][1].properties.name = "HAPTIC_MT_mode_pie"


def unregister() -> None:
    for keymap, item in _items:
        keymap.keymap_items.remove(item)
    _items.clear()
