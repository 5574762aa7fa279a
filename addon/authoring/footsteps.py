"""The soles with which a character strikes what it walks on, and the meshes under its feet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bmesh
import bpy
import numpy as np
from bpy.types import Collection, Object, Scene
from mathutils import Matrix

from ..blender.polling import receiving
from ..blender.units import metres_per_unit
from ..blender.words import report_text
from ..changes.suspension import suspended
from . import body_kit

_REACH = 0.25
"""Distance [m] of a foot's listener from what it stands on."""
_FRAMES = 32
"""Frames of the scene in which feet are looked at."""
STRIKING = 0.063 * 70.0
"""Mass [kg] that a heel strikes with: 6.3 % of a body's (Chi and Schmitt, J. Biomechanics 2005)."""
_FULL_ENERGY = 0.9
"""Energy [J] of steps of full strength: the middle of 0.2 to 4 J (ibid.)."""
_THICKNESS = 0.02
"""Of a sole [m]."""


def add_sole(foot: Object, skin: Object, collection: Collection) -> Object:
    """Add a box under what the bone of a ``foot``'s listener moves of a ``skin``, parented to that
    bone. Raises ValueError if it moves nothing."""
    armature: Any = foot.parent
    bone = foot.parent_bone
    group = skin.vertex_groups.get(bone)
    own = [
        vertex.co[:]
        for vertex in skin.data.vertices
        if group is not None
        and any(item.group == group.index and item.weight > 0.5 for item in vertex.groups)
    ]
    if not own:
        raise ValueError(report_text("'{}' has no vertices of the bone '{}'", skin.name, bone))
    to_rest = np.array(armature.matrix_world.inverted_safe() @ skin.matrix_world)
    points = np.array(own) @ to_rest[:3, :3].T + to_rest[:3, 3]
    low, high = points.min(axis=0), points.max(axis=0)
    high[2] = low[2] + _THICKNESS / metres_per_unit(foot.users_scene[0])
    name = f"{armature.name} sole.{bone}"
    mesh, box = bpy.data.meshes.new(name), bmesh.new()
    bmesh.ops.create_cube(box, size=1.0, matrix=Matrix.Diagonal((*(high - low), 1.0)))
    box.to_mesh(mesh)
    box.free()
    sole = bpy.data.objects.new(name, mesh)
    receiving(collection).objects.link(sole)
    sole.display_type, sole.hide_render = "BOUNDS", True
    sole.parent, sole.parent_type, sole.parent_bone = armature, "BONE", bone
    moved = armature.pose.bones[bone].matrix @ armature.data.bones[bone].matrix_local.inverted()
    sole.matrix_world = armature.matrix_world @ moved @ Matrix.Translation((low + high) / 2)
    return sole


def add_rule(scene: Scene, armature: Object) -> None:
    """Let the soles of a character strike with the energies of steps."""
    rule = scene.haptics.impact_table.items.add()
    rule.first_kind, rule.first = "OBJECT", f"{armature.name} sole.*"
    rule.full_energy = _FULL_ENERGY


def ground_of(scene: Scene, armature: Object, feet: Sequence[Object]) -> list[Object]:
    """The meshes, other than the character's own, in whose bounding box, widened by the reach of a
    foot, one of the ``feet`` is in a frame of the scene, which is set to these frames."""
    own = {*body_kit.skins(armature), *armature.children_recursive}
    meshes = [obj for obj in scene.objects if obj.type == "MESH" and obj not in own]
    shown = scene.frame_current
    count = min(_FRAMES, scene.frame_end - scene.frame_start + 1)
    places = []
    with suspended():
        for frame in np.linspace(scene.frame_start, scene.frame_end, count).round():
            scene.frame_set(int(frame))
            places += [tuple(foot.matrix_world.translation) for foot in feet]
        scene.frame_set(shown)
    points = np.array(places)
    reach = _REACH / metres_per_unit(scene)
    found = []
    for obj in meshes:
        corners = np.array([corner[:] for corner in obj.bound_box])
        matrix = np.array(obj.matrix_world)
        corners = corners @ matrix[:3, :3].T + matrix[:3, 3]
        low, high = corners.min(axis=0) - reach, corners.max(axis=0) + reach
        if ((low <= points) & (points <= high)).all(axis=1).any():
            found.append(obj)
    return found
