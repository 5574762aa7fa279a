"""The ten listeners of the default set-up on a body."""

from __future__ import annotations

import bpy
from bpy.types import Context, Operator
from mathutils import Vector

from ...core.body import BODY_PART, DEFAULT_LISTENERS
from ..scene_reader import haptic_carrier
from .polling import SOLID_TYPES, UNDO, poll_active


class HAPTIC_OT_add_default_listeners(Operator):
    """Add the ten listeners of the default set-up as empties on the active object: ears, hands, upper back, middle back and upper legs"""

    bl_idname = "haptic.add_default_listeners"
    bl_label = "Add Ten Listeners"
    bl_options = UNDO

    @classmethod
    def poll(cls, context: Context) -> bool:
        return poll_active(cls, context)

    def execute(self, context: Context) -> set[str]:
        body = context.object
        if haptic_carrier(body) is None:
            if body.type not in SOLID_TYPES:
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


CLASSES = (HAPTIC_OT_add_default_listeners,)
