"""The add-on's shortcuts."""

from __future__ import annotations

import bpy
from bpy.types import KeyMap, KeyMapItem

_items: list[tuple[KeyMap, KeyMapItem]] = []


def register() -> None:
    """Add the shortcuts: in the viewport those of tracing and modes, in every editor those of live
    output."""
    configuration = bpy.context.window_manager.keyconfigs.addon
    if configuration is None:  # in the background
        return
    viewport = configuration.keymaps.new(name="3D View", space_type="VIEW_3D")
    screen = configuration.keymaps.new(name="Screen", space_type="EMPTY")
    for keymap, operator, values, key, alt in (
        (viewport, "wm.context_toggle", {"data_path": "scene.haptics.tracing"}, "T", True),
        (viewport, "wm.call_menu_pie", {"name": "HAPTIC_MT_mode_pie"}, "M", True),
        (screen, "haptic.panic", {}, "BACK_SPACE", False),
        (screen, "haptic.toggle_preview", {}, "H", True),
    ):
        item = keymap.keymap_items.new(operator, key, "PRESS", ctrl=True, shift=True, alt=alt)
        for name, value in values.items():
            setattr(item.properties, name, value)
        _items.append((keymap, item))


def unregister() -> None:
    """Remove them."""
    for keymap, item in _items:
        keymap.keymap_items.remove(item)
    _items.clear()
