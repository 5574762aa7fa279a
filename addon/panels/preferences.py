"""The add-on's preferences, as Blender draws them."""

from __future__ import annotations

import rna_keymap_ui
from bpy.types import AddonPreferences, Context, KeyMapItem, UILayout

from ...core import plugins
from ..blender.extension import ROOT
from ..blender.words import ui_text
from ..properties.preferences import PreferenceProperties
from .drawing import draw_each, settings_layout, warn

_KEYMAPS = ("3D View", "Screen")


class HapticTracingPreferences(PreferenceProperties, AddonPreferences):
    bl_idname = ROOT

    def draw(self, context: Context) -> None:
        layout = settings_layout(self)
        draw_each(
            layout.column(heading="Display"),
            self,
            "gain_unit",
            "overlay_size",
            "curve_colour",
            "show_quick_start",
        )
        draw_each(
            layout.column(heading="Devices"), self, "default_device", "keep_awake", "haptic_players"
        )
        draw_failures(layout)
        draw_shortcuts(layout, context)


def draw_failures(layout: UILayout) -> None:
    """Draw the plug-ins that are left out, and why."""
    for name, reason in plugins.failures.items():
        warn(layout, ui_text("The plug-in {} is left out:", name), reason)


_OF_BLENDER = {
    "wm.call_menu_pie": ("name", "HAPTIC_"),
    "wm.context_toggle": ("data_path", "scene.haptics."),
}
"""Blender's operators of shortcuts of the add-on: a property, and how it begins."""


def draw_shortcuts(layout: UILayout, context: Context) -> None:
    """Draw the add-on's shortcuts for editing."""
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
    """Whether a shortcut runs an operator of the add-on, opens one of its menus or toggles one of
    its properties."""
    name, start = _OF_BLENDER.get(item.idname, ("", ""))
    return item.idname.startswith("haptic.") or (
        bool(name) and getattr(item.properties, name, "").startswith(start)
    )
