"""Menus: Object > Haptics, through which search (F3) finds every operator, and Add > Haptic."""

from __future__ import annotations

import bpy
from bpy.types import Context, Menu

from ...core.scene.values import MODES
from ...sample_scenes import SAMPLES
from ..blender.words import ui_text
from .thumbnails import cell

# Operators on the selection, on the scene, on materials; unknown ones are left out.
_SELECTION = (
    ("haptic.make_objects", "OUTLINER_OB_META"),
    ("haptic.add_source", "OUTLINER_OB_FORCE_FIELD"),
    ("haptic.add_listener", "OUTLINER_OB_LIGHTPROBE"),
    ("haptic.add_default_listeners", "OUTLINER_OB_ARMATURE"),
    ("haptic.add_footsteps", "MOD_DYNAMICPAINT"),
    ("haptic.clear", "X"),
)
_MATERIALS = (
    ("haptic.guess_material", "VIEWZOOM"),
    ("haptic.new_material", "ADD"),
    ("haptic.remove_material", "REMOVE"),
)
_SCENE = (("haptic.trace_frame", "FILE_REFRESH"),)


def _draw(menu: Menu, entries: tuple[tuple[str, str], ...]) -> None:
    for name, icon in entries:
        menu.layout.operator(name, icon=icon)


def others() -> list[str]:
    """The add-on's operators that are in no other menu, by label."""
    listed = {
        name for entries in (_SELECTION, _MATERIALS, _SCENE) for name, _ in entries
    } | NEEDS_MORE
    labels = {
        f"haptic.{name}": getattr(bpy.ops.haptic, name).get_rna_type().name
        for name in dir(bpy.ops.haptic)
    }
    return sorted(labels.keys() - listed, key=lambda name: labels[name])


NEEDS_MORE = {
    "haptic.apply_material",
    "haptic.select_object",
    "haptic.add_source_object",
    "haptic.add_medium",
    "haptic.add_sample",
}
"""Operators that need arguments from other menus and panels."""


class HAPTIC_MT_object(Menu):
    bl_label = "Haptics"

    def draw(self, context: Context) -> None:
        _draw(self, _SELECTION)
        self.layout.separator()
        self.layout.menu("HAPTIC_MT_materials", icon="MATERIAL")
        _draw(self, _MATERIALS)
        self.layout.separator()
        _draw(self, _SCENE)
        self.layout.prop(context.scene.haptics, "tracing")
        self.layout.menu("HAPTIC_MT_more")


class HAPTIC_MT_more(Menu):
    """The rest of the operators, so that search finds them"""

    bl_label = "More"

    def draw(self, context: Context) -> None:
        for name in others():
            self.layout.operator(name)


_SAMPLE = 6.0  # lines high: large enough to tell scenes apart


class HAPTIC_MT_add(Menu):
    bl_label = "Haptic"

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.operator_context = "EXEC_REGION_WIN"
        layout.operator_enum("haptic.add_source_object", "kind")
        layout.separator()
        layout.operator_enum("haptic.add_medium", "medium")
        layout.separator()
        layout.operator("haptic.add_default_listeners", icon="OUTLINER_OB_ARMATURE")
        layout.menu("HAPTIC_MT_samples", icon="SCENE_DATA")


class HAPTIC_MT_samples(Menu):
    bl_label = "Sample Scenes"

    def draw(self, context: Context) -> None:
        flow = self.layout.column_flow(columns=3)
        for sample in SAMPLES.values():
            cell(flow, f"sample-{sample.name}", scale=_SAMPLE).operator(
                "haptic.add_sample", text=sample.title
            ).sample = sample.name


class HAPTIC_MT_mode_pie(Menu):
    """The four modes around the pointer, to compare them"""

    bl_label = "Haptic Mode"

    def draw(self, context: Context) -> None:
        pie = self.layout.menu_pie()
        for mode, (title, _) in MODES.items():
            text = f"{ui_text(title)} ({mode})"
            pie.prop_enum(context.scene.haptics, "mode", mode.value, text=text, translate=False)


def draw_object_menu(self: Menu, context: Context) -> None:
    """Entry of the Object menu."""
    self.layout.separator()
    self.layout.menu("HAPTIC_MT_object", icon="OUTLINER_OB_LIGHTPROBE")


def draw_add_menu(self: Menu, context: Context) -> None:
    """Entry of the Add menu."""
    self.layout.separator()
    self.layout.menu("HAPTIC_MT_add", icon="OUTLINER_OB_LIGHTPROBE")
