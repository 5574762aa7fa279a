"""Panel "Export": the haptic entries of File > Export and File > Import."""

from __future__ import annotations

from bpy.types import Context, Panel

from ..blender import job
from .drawing import ClosedPanel


class HAPTIC_PT_export(ClosedPanel, Panel):
    bl_label = "Export"
    bl_order = 90

    def draw(self, context: Context) -> None:
        layout = self.layout
        if job.draw_running(layout):
            return
        column = layout.column(align=True)
        column.operator("export_scene.haptic_scene", text="Haptic Scene", icon="EXPORT")
        column.operator("export_scene.haptic_tracks", text="Haptic Tracks", icon="EXPORT")
        column = layout.column(align=True)
        column.operator("import_scene.haptic_scene", text="Haptic Scene", icon="IMPORT")
        column.operator("haptic.import_signal", icon="IMPORT")
