"""Operators that give roles to objects and take them away."""

from __future__ import annotations

from bpy.props import EnumProperty
from bpy.types import Context, Operator

from ..scene_reader import haptic_carrier
from .polling import SOLID_TYPES, UNDO, editable, poll_active, poll_selected


class HAPTIC_OT_make_objects(Operator):
    """Let vibration pass through the selected objects"""

    bl_idname = "haptic.make_objects"
    bl_label = "Make Haptic"
    bl_options = UNDO

    @classmethod
    def poll(cls, context: Context) -> bool:
        return poll_selected(cls, context)

    def execute(self, context: Context) -> set[str]:
        solid = [obj for obj in editable(context.selected_objects) if obj.type in SOLID_TYPES]
        if not solid:
            self.report(
                {"ERROR"},
                "None of the selected objects has a surface that can touch others; select meshes that are not linked from a library",
            )
            return {"CANCELLED"}
        for obj in solid:
            obj.haptics.enabled = True
        self.report({"INFO"}, f"{len(solid)} object{'s' if len(solid) > 1 else ''} made haptic")
        return {"FINISHED"}


class HAPTIC_OT_add_source(Operator):
    """Make the active object a haptic source: it emits a signal into the objects that it touches"""

    bl_idname = "haptic.add_source"
    bl_label = "Add Source"
    bl_options = UNDO

    signal: EnumProperty(name="Signal", items=(("SINE", "Sine", ""), ("PULSE", "Pulse Train", ""), ("NOISE", "Noise", "")), default="SINE")

    @classmethod
    def poll(cls, context: Context) -> bool:
        return poll_active(cls, context)

    def execute(self, context: Context) -> set[str]:
        obj = context.object
        if haptic_carrier(obj) is None:
            if obj.type not in SOLID_TYPES:
                self.report(
                    {"ERROR"}, f"'{obj.name}' has no surface: parent it to a haptic object first, so that it has something to shake"
                )
                return {"CANCELLED"}
            obj.haptics.enabled = True
        obj.haptics.source.enabled = True
        obj.haptics.source.signal = self.signal
        return {"FINISHED"}


class HAPTIC_OT_add_listener(Operator):
    """Make the selected objects haptic listeners: what arrives at their origins is felt"""

    bl_idname = "haptic.add_listener"
    bl_label = "Add Listener"
    bl_options = UNDO

    @classmethod
    def poll(cls, context: Context) -> bool:
        return poll_selected(cls, context)

    def execute(self, context: Context) -> set[str]:
        nowhere = []
        for obj in editable(context.selected_objects):
            if haptic_carrier(obj) is None:
                if obj.type not in SOLID_TYPES:
                    nowhere.append(obj.name)
                    continue
                obj.haptics.enabled = True
            obj.haptics.listener.enabled = True
        if nowhere:
            self.report({"ERROR"}, f"Parent these to haptic objects first, so that they touch something: {', '.join(nowhere[:5])}")
            return {"CANCELLED"}
        return {"FINISHED"}


class HAPTIC_OT_clear(Operator):
    """Take all haptic roles from the selected objects; their settings are kept for later"""

    bl_idname = "haptic.clear"
    bl_label = "Clear Haptics"
    bl_options = UNDO

    @classmethod
    def poll(cls, context: Context) -> bool:
        return poll_selected(cls, context)

    def execute(self, context: Context) -> set[str]:
        for obj in editable(context.selected_objects):
            obj.haptics.enabled = obj.haptics.source.enabled = obj.haptics.listener.enabled = False
        return {"FINISHED"}


CLASSES = (HAPTIC_OT_make_objects, HAPTIC_OT_add_source, HAPTIC_OT_add_listener, HAPTIC_OT_clear)
