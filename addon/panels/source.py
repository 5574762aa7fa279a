"""Panel "Haptic Source": what the active object emits."""

from __future__ import annotations

from bpy.types import Context, Menu, Panel

from .drawing import HapticsPanel, draw_carrier
from .thumbnails import cell


class HAPTIC_MT_signals(Menu):
    bl_label = "Signals"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.object is not None

    def draw(self, context: Context) -> None:
        flow = self.layout.column_flow(columns=3)
        for kind in ("SINE", "PULSE", "NOISE"):
            cell(flow, f"signal-{kind}").prop_enum(context.object.haptics.source, "signal", kind)


class HAPTIC_PT_source(HapticsPanel, Panel):
    bl_label = "Haptic Source"
    bl_order = 20

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.object is not None

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.object.haptics.source, "enabled", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        source = context.object.haptics.source
        if not source.enabled:
            return
        layout.prop(source, "amplitude")
        row = layout.row(align=True)
        row.prop(source, "signal")
        row.menu("HAPTIC_MT_signals", text="", icon="IMGDISPLAY")
        if source.signal == "FILE":
            layout.prop(source, "filepath")
        elif source.signal not in ("NOISE", "KEPT"):
            layout.prop(source, "frequency")
        layout.operator("haptic.import_signal", icon="IMPORT")
        layout.prop(source, "decay")
        layout.prop(source, "priority")
        layout.prop(source, "muted")
        draw_carrier(layout, context.object, "Shakes")
