"""File > Export > Haptic Scene (.json)."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty
from bpy.types import Context, Menu, Operator
from bpy_extras.io_utils import ExportHelper

from ..core.formats.scene_json import write_scene
from ..core.frame_result import FrameResult
from ..core.scene import HapticScene
from . import session
from .scene_reader import Reading


def scene_of_frame(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> HapticScene:
    """The haptic scene as it stands in the current frame, contacts included. Raises ValueError in words where nothing can be traced."""
    result = session.trace(scene, depsgraph)
    reading = session.of(scene).reading
    if result is None or reading is None:
        problems = session.problems_of(scene)
        raise ValueError(problems[0].message if problems else "Nothing is tagged: select objects and press Make Haptic")
    return scene_of_result(result, reading)


def scene_of_result(result: FrameResult, reading: Reading) -> HapticScene:
    """The haptic scene of a traced frame and the reading that it was traced from."""
    return HapticScene(
        objects=reading.posed_objects(),
        contacts=result.contacts.to_contacts(result.objects),
        sources=result.sources,
        listeners=result.listeners,
        settings=reading.settings,
    )


class HAPTIC_OT_export_scene(Operator, ExportHelper):
    """Write the haptic objects, sources, listeners and contacts of the current frame as a haptic scene"""

    bl_idname = "export_scene.haptic_scene"
    bl_label = "Export Haptic Scene"
    bl_options = {"PRESET"}

    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})

    def execute(self, context: Context) -> set[str]:
        try:
            write_scene(scene_of_frame(context.scene, context.evaluated_depsgraph_get()), self.filepath)
        except (ValueError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"Haptic scene written: {self.filepath}")
        return {"FINISHED"}


def _menu(self: Menu, context: Context) -> None:
    self.layout.operator(HAPTIC_OT_export_scene.bl_idname, text="Haptic Scene (.json)")


def register() -> None:
    bpy.utils.register_class(HAPTIC_OT_export_scene)
    bpy.types.TOPBAR_MT_file_export.append(_menu)


def unregister() -> None:
    bpy.types.TOPBAR_MT_file_export.remove(_menu)
    bpy.utils.unregister_class(HAPTIC_OT_export_scene)
