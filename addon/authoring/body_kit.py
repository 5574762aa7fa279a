"""Listeners placed on a body: on the bones of an armature, or in the bounding box of a mesh."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import bpy
import numpy as np
from bpy.types import Collection, Object
from mathutils import Matrix, Vector

from ...core.scene.body import BodyPart
from ...core.scene.skeleton import Bone, PartPlace, places
from ..blender.polling import receiving
from ..scene_reader.collision_shapes import vertices_of

# Positions of the parts of a standing body in its bounding box: from the middle to the side (left
# is +x), from front (-y) to back, height.
_PLACES = {
    "head": (0.0, 0.5, 0.93),
    "ear": (0.15, 0.5, 0.93),
    "chest": (0.2, 0.2, 0.76),
    "belly": (0.0, 0.2, 0.62),
    "hips": (0.0, 0.5, 0.52),
    "upper_back": (0.3, 0.8, 0.78),
    "middle_back": (0.3, 0.8, 0.62),
    "upper_arm": (0.6, 0.5, 0.73),
    "forearm": (0.85, 0.5, 0.6),
    "hand": (0.95, 0.5, 0.48),
    "index_finger": (0.97, 0.4, 0.43),
    "upper_leg": (0.35, 0.5, 0.4),
    "lower_leg": (0.35, 0.5, 0.2),
    "foot": (0.35, 0.35, 0.03),
}
_FEET = 0.05
"""Height of the feet, of that of the body."""


def listeners_on(body: Object) -> dict[str, Object]:
    """The listeners of a body or armature, by body part."""
    return {
        child.haptics.listener.body_part: child
        for child in body.children
        if child.haptics.listener.enabled
    }


def place_on_mesh(body: Object, parts: Sequence[BodyPart], collection: Collection) -> None:
    """Place empties as listeners at the parts of a standing body that fills the bounding box of
    ``body``; feet in the box of what is as low as they are, however far its arms reach. Raises
    ValueError where it has no surface."""
    corners = vertices_of(body, bpy.context.evaluated_depsgraph_get(), "FINAL")
    bottom = corners[:, 2].min()
    top = corners[:, 2].max()
    lowest = corners[corners[:, 2] <= bottom + _FEET * (top - bottom)]
    for part in parts:
        name = part.name.partition(".")[0]
        offset, depth, height = _PLACES[name]
        across = 0.5 + {"L": 0.5, "R": -0.5, "": 0.0}[part.side] * offset
        near = lowest if name == "foot" else corners
        x, y = near[:, :2].min(axis=0) + (across, depth) * np.ptp(near[:, :2], axis=0)
        local = Vector((x, y, bottom + height * (top - bottom)))
        listener = add_listener(part, f"{body.name} {part.name}", collection)
        attach(listener, body, "", body.matrix_world @ local)


def place_on_bones(
    armature: Object, parts: Sequence[BodyPart], collection: Collection
) -> list[BodyPart]:
    """Place empties as listeners, each parented to the bone of its part. Returns the parts without
    a bone.

    Raises ValueError if it is not the armature of a body.
    """
    # In armature space.
    at_rest = [
        Bone(bone.name, tuple(bone.head_local), tuple(bone.tail_local))
        for bone in armature.data.bones
    ]
    found: Mapping[str, PartPlace] = places(at_rest, parts)
    for part in parts:
        place = found.get(part.name)
        if place is not None:
            listener = add_listener(part, f"{armature.name} {part.name}", collection)
            attach(
                listener, armature, place.bone, posed(armature, place.bone, Vector(place.position))
            )
    return [part for part in parts if part.name not in found]


def posed(armature: Object, bone: str, rest: Vector) -> Vector:
    """The current world position of a point of a bone; ``rest``: its position at rest, in armature
    space."""
    local = armature.data.bones[bone].matrix_local.inverted() @ rest
    return armature.matrix_world @ armature.pose.bones[bone].matrix @ local


def add_listener(part: BodyPart, name: str, collection: Collection) -> Object:
    """Add a listener as an empty, displayed as the bounding volume of the part."""
    empty = bpy.data.objects.new(name, None)
    receiving(collection).objects.link(empty)
    empty.empty_display_type = "SPHERE"
    listener = empty.haptics.listener
    listener.enabled = True
    listener.body_part = part.name
    listener.radius = part.radius  # and so is the empty displayed
    return empty


def attach(obj: Object, parent: Object, bone: str, place: Vector) -> None:
    """Parent an object, to ``bone`` unless that is "", and move it to the world position ``place``
    without rotation and scale."""
    carried = parent.matrix_world
    obj.parent = parent
    if bone:
        obj.parent_type, obj.parent_bone = "BONE", bone
        carried = (
            carried
            @ parent.pose.bones[bone].matrix
            @ Matrix.Translation((0, parent.data.bones[bone].length, 0))
        )
    obj.matrix_parent_inverse = carried.inverted_safe()
    obj.matrix_basis = Matrix.Translation(place)


def armature_of(obj: Object) -> Object | None:
    """The object itself if it is an armature, else the armature that deforms it."""
    if obj.type == "ARMATURE":
        return obj
    return obj.find_armature() if obj.type == "MESH" else None


def skins(armature: Object) -> list[Object]:
    """The meshes that an armature deforms, the largest first."""
    moved = [
        obj
        for obj in bpy.context.scene.objects
        if obj.type == "MESH" and obj.find_armature() == armature
    ]
    return sorted(moved, key=lambda obj: -obj.dimensions.length)
