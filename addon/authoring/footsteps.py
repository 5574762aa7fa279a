"""Footsteps of a character: the skins of its feet, a rule for their impacts, and the ground."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from bpy.types import Object, Scene

from ...core.scene.body import GENTLEST_STEP
from ..blender.units import metres_per_unit
from ..changes.suspension import suspended
from . import body_kit

_REACH = 0.25
"""Distance [m] of a foot's listener from what it stands on."""
_FRAMES = 32
"""Frames of the scene in which feet are looked at."""


def with_feet(skins: Sequence[Object], feet: Sequence[Object]) -> list[Object]:
    """The skins of which the bones of the listeners of ``feet`` move vertices."""
    bones = {foot.parent_bone for foot in feet}
    found = []
    for skin in skins:
        groups = {group.index for group in skin.vertex_groups if group.name in bones}
        entries = (entry for vertex in skin.data.vertices for entry in vertex.groups)
        if groups and any(entry.group in groups and entry.weight > 0.5 for entry in entries):
            found.append(skin)
    return found


def add_rule(scene: Scene, skin: Object) -> None:
    """Let the gentlest steps of people on a skin's feet be felt at full strength."""
    table = scene.haptics.impact_table.items
    if all(rule.first != skin.name for rule in table):
        rule = table.add()
        rule.first_kind, rule.first = "OBJECT", skin.name
        rule.full_energy = GENTLEST_STEP


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
