"""Operators: tag objects, trace, look at problems."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty
from bpy.types import Context, Object, Operator
from mathutils import Vector

from ..core.body import BODY_PART, DEFAULT_LISTENERS
from . import session
from .overlay import draw
from .scene_reader import haptic_carrier

_UNDO = {"REGISTER", "UNDO"}
_SOLID_TYPES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}


def _editable(objects: list[Object]) -> list[Object]:
    return [obj for obj in objects if obj.is_editable]


def _poll_object_mode(cls: type[Operator], context: Context) -> bool:
    if context.mode != "OBJECT":
        cls.poll_message_set("Switch to Object Mode first")
        return False
    return True


def _poll_selected(cls: type[Operator], context: Context) -> bool:
    if not _poll_object_mode(cls, context):
        return False
    if not context.selected_objects:
        cls.poll_message_set("Select one or more objects first")
        return False
    return True


class HAPTIC_OT_make_objects(Operator):
    """Let vibration pass through the selected objects"""

    bl_idname = "haptic.make_objects"
    bl_label = "Make Haptic"
    bl_options = _UNDO

    @classmethod
    def poll(cls, context: Context) -> bool:
        return _poll_selected(cls, context)

    def execute(self, context: Context) -> set[str]:
        solid = [obj for obj in _editable(context.selected_objects) if obj.type in _SOLID_TYPES]
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
    bl_options = _UNDO

    signal: EnumProperty(name="Signal", items=(("SINE", "Sine", ""), ("PULSE", "Pulse Train", ""), ("NOISE", "Noise", "")), default="SINE")

    @classmethod
    def poll(cls, context: Context) -> bool:
        return _poll_active(cls, context)

    def execute(self, context: Context) -> set[str]:
        obj = context.object
        if haptic_carrier(obj) is None:
            if obj.type not in _SOLID_TYPES:
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
    bl_options = _UNDO

    @classmethod
    def poll(cls, context: Context) -> bool:
        return _poll_selected(cls, context)

    def execute(self, context: Context) -> set[str]:
        nowhere = []
        for obj in _editable(context.selected_objects):
            if haptic_carrier(obj) is None:
                if obj.type not in _SOLID_TYPES:
                    nowhere.append(obj.name)
                    continue
                obj.haptics.enabled = True
            obj.haptics.listener.enabled = True
        if nowhere:
            self.report({"ERROR"}, f"Parent these to haptic objects first, so that they touch something: {', '.join(nowhere[:5])}")
            return {"CANCELLED"}
        return {"FINISHED"}


class HAPTIC_OT_add_default_listeners(Operator):
    """Add the ten listeners of the default set-up as empties on the active object: ears, hands, upper back, middle back and upper legs"""

    bl_idname = "haptic.add_default_listeners"
    bl_label = "Add Ten Listeners"
    bl_options = _UNDO

    @classmethod
    def poll(cls, context: Context) -> bool:
        return _poll_active(cls, context)

    def execute(self, context: Context) -> set[str]:
        body = context.object
        if haptic_carrier(body) is None:
            if body.type not in _SOLID_TYPES:
                self.report({"ERROR"}, f"'{body.name}' has no surface: select the mesh of the avatar")
                return {"CANCELLED"}
            body.haptics.enabled = True
        corners = [Vector(corner) for corner in body.bound_box]
        low = Vector(map(min, zip(*corners, strict=True)))
        high = Vector(map(max, zip(*corners, strict=True)))
        for name in DEFAULT_LISTENERS:
            empty = bpy.data.objects.new(f"{body.name} {name}", None)
            context.collection.objects.link(empty)
            empty.parent = body
            empty.location = _place_on_body(name, low, high)
            empty.empty_display_type = "SPHERE"
            empty.empty_display_size = BODY_PART[name].radius
            listener = empty.haptics.listener
            listener.enabled = True
            listener.body_part = name
            listener.radius = BODY_PART[name].radius
        return {"FINISHED"}


# Where the parts of a standing body are, as fractions of its bounding box: side (left is +x), front (-y) to back, height.
_PLACES = {
    "ear": (0.15, 0.5, 0.93),
    "hand": (0.95, 0.5, 0.48),
    "upper_back": (0.3, 0.8, 0.78),
    "middle_back": (0.3, 0.8, 0.62),
    "upper_leg": (0.35, 0.5, 0.4),
}


def _place_on_body(name: str, low: Vector, high: Vector) -> Vector:
    part, side = name.split(".")
    offset, depth, height = _PLACES[part]
    across = 0.5 + (0.5 if side == "L" else -0.5) * offset
    return Vector(low[axis] + fraction * (high[axis] - low[axis]) for axis, fraction in enumerate((across, depth, height)))


class HAPTIC_OT_clear(Operator):
    """Take all haptic roles from the selected objects; their settings are kept for later"""

    bl_idname = "haptic.clear"
    bl_label = "Clear Haptics"
    bl_options = _UNDO

    @classmethod
    def poll(cls, context: Context) -> bool:
        return _poll_selected(cls, context)

    def execute(self, context: Context) -> set[str]:
        for obj in _editable(context.selected_objects):
            obj.haptics.enabled = obj.haptics.source.enabled = obj.haptics.listener.enabled = False
        return {"FINISHED"}


class HAPTIC_OT_trace_frame(Operator):
    """Trace the current frame again, reading everything anew"""

    bl_idname = "haptic.trace_frame"
    bl_label = "Trace This Frame"

    def execute(self, context: Context) -> set[str]:
        session.of(context.scene).reader.forget_shapes()
        result = session.trace(context.scene, context.evaluated_depsgraph_get())
        if result is None:
            problems = session.problems_of(context.scene)
            self.report({"WARNING"}, problems[0].message if problems else "Nothing is tagged: select objects and press Make Haptic")
            return {"CANCELLED"}
        draw.redraw()
        return {"FINISHED"}


class HAPTIC_OT_select_object(Operator):
    """Select the object and make it active"""

    bl_idname = "haptic.select_object"
    bl_label = "Select Object"
    bl_options = _UNDO

    name: StringProperty(name="Object", description="Name of the object", options={"SKIP_SAVE"})
    extend: BoolProperty(name="Extend", description="Keep what is selected", default=False, options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context: Context) -> bool:
        return _poll_object_mode(cls, context)

    def execute(self, context: Context) -> set[str]:
        found: Any = next((obj for obj in context.view_layer.objects if obj.name_full == self.name), None)
        if found is None:
            self.report({"WARNING"}, f"There is no object '{self.name}' in this view layer any more")
            return {"CANCELLED"}
        if not self.extend:
            for obj in context.selected_objects:
                obj.select_set(False)
        found.select_set(True)
        context.view_layer.objects.active = found
        return {"FINISHED"}


def _poll_active(cls: type[Operator], context: Context) -> bool:
    if not _poll_object_mode(cls, context):
        return False
    if context.object is None:
        cls.poll_message_set("Select an object first")
        return False
    if not context.object.is_editable:
        cls.poll_message_set("The active object is linked from a library; make it local or override it first")
        return False
    return True


CLASSES = (
    HAPTIC_OT_make_objects,
    HAPTIC_OT_add_source,
    HAPTIC_OT_add_listener,
    HAPTIC_OT_add_default_listeners,
    HAPTIC_OT_clear,
    HAPTIC_OT_trace_frame,
    HAPTIC_OT_select_object,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
