"""Shortcuts: panic and the preview."""

from __future__ import annotations

import bpy

_items: list[tuple[bpy.types.KeyMap, bpy.types.KeyMapItem]] = []


def register() -> None:
    configuration = bpy.context.window_manager.keyconfigs.addon
    if configuration is None:  # in the background
        return
    keymap = configuration.keymaps.new(name="Screen", space_type="EMPTY")
    for operator, key in (("haptic.panic", "BACK_SPACE"), ("haptic.toggle_preview", "H")):
        _items.append((keymap, keymap.keymap_items.new(operator, key, "PRESS", ctrl=True, shift=True, alt=key == "H")))


def unregister() -> None:
    for keymap, item in _items:
        keymap.keymap_items.remove(item)
    _items.clear()
