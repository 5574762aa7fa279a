"""Panel "Haptic Object": how the active object passes vibration on."""

from __future__ import annotations

from typing import Any

from bpy.types import Context, Panel, UILayout

from .drawing import HapticsPanel, warn


class HAPTIC_PT_object(HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_object"
    bl_label = "Haptic Object"
    bl_order = 10

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.object is not None

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.object.haptics, "enabled", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        obj = context.object
        haptics = obj.haptics
        layout.active = haptics.enabled
        layout.label(text=obj.name, icon="OBJECT_DATA")
        column = layout.column(align=True)
        column.prop(haptics, "kappa")
        column.prop(haptics, "rho")
        _draw_function(layout, haptics)
        column = layout.column()
        column.prop(haptics, "wave_speed")
        column.prop(haptics, "medium")
        if haptics.enabled and obj.rigid_body is not None and context.scene.rigidbody_world is None:
            warn(layout, "This rigid body does not move:", "the scene has no Rigid Body World")


def _draw_function(layout: UILayout, haptics: Any) -> None:
    layout.prop(haptics, "function")
    parameter = {"exponential": "alpha", "linear": "range", "constant": "constant", "expression": "expression"}.get(haptics.function)
    if parameter is not None:
        layout.prop(haptics, parameter)


CLASSES = (HAPTIC_PT_object,)
