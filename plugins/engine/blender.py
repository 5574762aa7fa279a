"""The operator that exports for an engine, and the hooks and options of Blender's glTF exporter."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import bpy
from bpy.props import PointerProperty, StringProperty
from bpy.types import Context, Menu, Panel, PropertyGroup, UILayout

from ...addon.blender.extension import ROOT
from ...addon.blender.polling import Action
from ...addon.blender.words import TranslatedError
from ...addon.gateway import StandIn
from ...addon.operators.exporting import RangeExport, written
from ...addon.properties.kinds import switch, text

export = StandIn(f"{__package__}.export")
gltf = StandIn(f"{__package__}.gltf")


class HapticGltfProperties(PropertyGroup):
    """The data that is written when the scene is exported as glTF."""

    use_extras: switch(
        "Haptics", "Roles, haptic properties, functions and contacts, in the extras of nodes", True
    )
    use_material: switch(
        "MPEG Haptic Material", "Haptic materials of meshes as an extension of ISO/IEC 23090-14"
    )
    material_name: text(
        "Name",
        "Name of that extension, because drafts of the standard differ",
        "MPEG_haptic_material",
        maxlen=60,
    )


class HAPTIC_OT_export_engine(RangeExport, Action):
    """Write the scene as glTF, and its haptics with the same names"""

    bl_idname = "export_scene.haptic_engine"
    bl_label = "Export for an Engine"
    bl_options = {"PRESET"}
    endings = (".glb",)
    filename_ext = ".glb"

    filter_glob: StringProperty(default="*.glb", options={"HIDDEN"})

    def draw(self, context: Context) -> None:
        self.draw_range(self.options_layout())

    def apply(self, context: Context) -> None:
        path = Path(bpy.path.abspath(self.filepath.removesuffix(".glb")))
        if not path.parent.is_dir():
            raise TranslatedError("There is no folder {}", path.parent)
        files = export.write(context.scene, self.frame_start, self.frame_end, path)
        for kind, words in written(files, ()):
            self.report(kind, words)


CLASSES = (HapticGltfProperties, HAPTIC_OT_export_engine)


def draw_export(context: Context, layout: UILayout) -> None:
    """The panel in the glTF exporter's sidebar."""
    header, body = layout.panel("haptic_tracing_gltf", default_closed=False)
    header.label(text="Haptic Tracing")
    if body is None:
        return
    scene: Any = context.scene
    properties = scene.haptic_gltf
    body.use_property_split = True
    body.prop(properties, "use_extras")
    body.prop(properties, "use_material")
    if properties.use_material:
        body.prop(properties, "material_name")


def draw_import(context: Context, layout: UILayout) -> None:
    """Draw nothing: there are no options of the import."""


_HOOKS: dict[str, Any] = {
    "glTF2ExportUserExtension": lambda: gltf.glTF2ExportUserExtension(),
    "glTF2ImportUserExtension": lambda: gltf.glTF2ImportUserExtension(),
    "draw_export": draw_export,
    "draw_import": draw_import,
}
"""What Blender's glTF exporter and importer look for in the modules of add-ons."""


def _draw_menu(self: Menu, context: Context) -> None:
    self.layout.operator("export_scene.haptic_engine", text="Haptics for an Engine (.glb)")


def _draw_panel(self: Panel, context: Context) -> None:
    self.layout.operator("export_scene.haptic_engine", icon="EXPORT")


_SCENES: Any = bpy.types.Scene
_ENTRIES = (("TOPBAR_MT_file_export", _draw_menu), ("HAPTIC_PT_export", _draw_panel))


def register() -> None:
    _SCENES.haptic_gltf = PointerProperty(type=HapticGltfProperties, name="glTF")
    for name, hook in _HOOKS.items():
        setattr(sys.modules[ROOT], name, hook)
    for place, entry in _ENTRIES:
        getattr(bpy.types, place).append(entry)


def unregister() -> None:
    for place, entry in _ENTRIES:
        getattr(bpy.types, place).remove(entry)
    for name in _HOOKS:
        delattr(sys.modules[ROOT], name)
    del _SCENES.haptic_gltf
