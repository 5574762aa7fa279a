"""The steps of the tutorial, one function each, with the operators that its reader presses."""

from __future__ import annotations

import math
from typing import Any

import bpy

WRIST = (-0.08, 0.0, 0.92)
SWING = math.radians(-75)
RAISED, STRIKES, LIFTED = (1, 16), (20, 24), 34  # frames
HAMMER_MASS = 1.5  # kilograms


def select(*names: str) -> None:
    """Select these objects; the first is the active one."""
    for obj in bpy.context.view_layer.objects:
        obj.select_set(obj.name in names)
    bpy.context.view_layer.objects.active = bpy.data.objects[names[0]]


def add_objects() -> None:
    """A table, a nail on it, a hammer whose head rests on the nail, the hand around the other end
    of its handle, and an empty in the hand that both turn about."""
    for obj in list(bpy.context.scene.objects):
        if obj.type == "MESH":
            bpy.data.objects.remove(obj)
    _add(
        "Table",
        bpy.ops.mesh.primitive_cube_add,
        size=1,
        location=(0, 0, 0.77),
        scale=(1.2, 0.6, 0.06),
    )
    _add(
        "Nail",
        bpy.ops.mesh.primitive_cylinder_add,
        radius=0.012,
        depth=0.06,
        location=(0.30, 0, 0.83),
    )
    _add(
        "Handle",
        bpy.ops.mesh.primitive_cube_add,
        size=1,
        location=(0.10, 0, 0.92),
        scale=(0.44, 0.03, 0.03),
    )
    _add(
        "Hammer",
        bpy.ops.mesh.primitive_cube_add,
        size=1,
        location=(0.30, 0, 0.92),
        scale=(0.05, 0.05, 0.12),
    )
    select("Hammer", "Handle")
    bpy.ops.object.join()
    _add("Hand", bpy.ops.mesh.primitive_uv_sphere_add, radius=0.05, location=WRIST)
    _add("Wrist", bpy.ops.object.empty_add, location=WRIST)
    select("Wrist", "Hammer", "Hand")
    bpy.ops.object.parent_set(keep_transform=True)


def _add(name: str, operator: Any, **arguments: Any) -> None:
    operator(**arguments)
    bpy.context.object.name = name


def make_haptic() -> None:
    """Everything lets vibration through."""
    select("Hammer", "Table", "Nail", "Hand")
    bpy.ops.haptic.make_objects()


def swing_the_hammer() -> None:
    """The hammer is raised, strikes the nail at frame 20 and is lifted again; at full speed until
    it strikes."""
    wrist = bpy.data.objects["Wrist"]
    for frame, angle in (
        (RAISED[0], SWING),
        (RAISED[1], SWING),
        (STRIKES[0], 0.0),
        (STRIKES[1], 0.0),
        (LIFTED, SWING),
    ):
        wrist.rotation_euler.y = angle
        wrist.keyframe_insert("rotation_euler", index=1, frame=frame)
    curve = _fcurve(wrist)
    for point in curve.keyframe_points:
        point.interpolation = "LINEAR"
    bpy.context.scene.frame_end = 40


def _fcurve(obj: Any) -> Any:
    action = obj.animation_data.action
    if hasattr(action, "layers"):
        return action.layers[0].strips[0].channelbags[0].fcurves[0]
    return action.fcurves[0]


def add_physics() -> None:
    """Impacts are between rigid bodies: table and nail stand still, the hammer follows its
    animation."""
    for name, kind in (("Table", "PASSIVE"), ("Nail", "PASSIVE"), ("Hammer", "ACTIVE")):
        select(name)
        bpy.ops.rigidbody.object_add(type=kind)
    body = bpy.data.objects["Hammer"].rigid_body
    body.kinematic = True
    body.mass = HAMMER_MASS


def add_listener() -> None:
    """The hand feels."""
    select("Hand")
    bpy.ops.haptic.add_listener()
    bpy.context.object.haptics.listener.body_part = "hand.L"


def play_to(frame: int) -> None:
    """Frame by frame, as playing does."""
    for number in range(1, frame + 1):
        bpy.context.scene.frame_set(number)


STEPS = (add_objects, make_haptic, swing_the_hammer, add_physics, add_listener)
