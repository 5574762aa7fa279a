"""Panel "Export"."""

from __future__ import annotations

from bpy.types import Context, Panel

from .drawing import HapticsPanel


class HAPTIC_PT_export(HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_export"
    bl_label = "Export"
    bl_order = 90
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        self.layout.operator("export_scene.haptic_scene", icon="EXPORT")


CLASSES = (HAPTIC_PT_export,)
