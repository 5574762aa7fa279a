"""Joints of a scene: points about which bones, keys, drivers or constraints only turn one part of
it on another."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np
from bpy.types import Object, PoseBone, Scene

from ...core.arrays import FloatArray
from ...core.contacts.shapes import quaternions
from ...core.scene.joint import Joint
from ..blender.arrays import read_array
from ..blender.compatibility import driving_curves, fcurves_of
from ..blender.time import stretching
from ..blender.units import metres_per_unit
from .known_motion import Curves, is_simulated
from .world_transforms import rigid_transforms

_PINS = ("FIXED", "HINGE", "POINT")
"""Types of rigid body constraints that keep a point of two bodies together."""
_STEADY = 1e-5
"""Change of a key's value that is rounding."""

_Link = tuple[Object, str]
"""An object, or, by its name, a bone of an armature, with all that is fixed to it."""


def joints_of(scene: Scene) -> tuple[Joint, ...]:
    """The joints between tagged objects. At rest, bones are where their armature has them, and
    objects where they are in the first frame, unturned where drivers turn them."""
    group = scene.rigidbody_world and scene.rigidbody_world.constraints
    pins = group.all_objects if group else ()
    if not pins and not any(obj.parent for obj in scene.objects):
        return ()
    linkage = _Linkage(scene)
    found: list[Joint] = []
    for link in linkage.parts:
        above = _above(link)
        if above is not None and not linkage.moves(link):
            found += linkage.joints(above, link, link)
    for pin in pins:
        joint = pin.rigid_body_constraint
        if joint and joint.enabled and joint.type in _PINS and joint.object1 and joint.object2:
            found += linkage.joints((joint.object1, ""), (joint.object2, ""), (pin, ""))
    return tuple(found)


class _Linkage:
    """How the objects of a scene hang together. ``parts``: the tagged ones by their link."""

    def __init__(self, scene: Scene) -> None:
        self._metres = metres_per_unit(scene)
        self._reach = 2 * scene.haptics.contact_tolerance
        self._rest = _Rest(scene.frame_start / stretching(scene) + np.arange(4.0))
        self._paths: dict[str, frozenset[str]] = {}
        self._boxes: dict[_Link, FloatArray] = {}
        self.parts: dict[_Link, list[Object]] = {}
        for obj in scene.objects:
            if obj.haptics.enabled:
                self.parts.setdefault(self.root((obj, "")), []).append(obj)

    def root(self, link: _Link) -> _Link:
        """The link that one is fixed to, itself if it can turn or move."""
        above = _above(link)
        while above is not None and not (self.moves(link) or self._turns(link)):
            link, above = above, _above(above)
        return link

    def moves(self, link: _Link) -> bool:
        """Whether animation or the simulation moves a link relative to the one above it."""
        obj, bone = link
        if bone:
            path = f'pose.bones["{bone}"].location'
            return not obj.data.bones[bone].use_connect and path in self._animated(obj)
        return is_simulated(obj) or "location" in self._animated(obj)

    def _turns(self, link: _Link) -> bool:
        """Whether something may turn a link: a constraint that moves it, too, parts the joint."""
        obj, bone = link
        if bone or any(not item.mute for item in obj.constraints):
            return True
        return any(path.startswith("rotation") for path in self._animated(obj))

    def _animated(self, obj: Object) -> frozenset[str]:
        """The data paths whose values change by animation."""
        if obj.name_full not in self._paths:
            curves = (*fcurves_of(obj), *driving_curves(obj))
            changing = (curve.data_path for curve in curves if _changes(curve))
            self._paths[obj.name_full] = frozenset(changing)
        return self._paths[obj.name_full]

    def joints(self, one: _Link, other: _Link, pivot: _Link) -> Iterator[Joint]:
        """The joints of the parts of two links that reach to the origin of a third."""
        place = self._place(pivot)[:3, 3]
        near = (self._near(link, place) for link in (one, other))
        for (first, turn, end), (second, other_turn, other_end) in product(*near):
            ends = _rounded(end), _rounded(other_end)
            rotation = quaternions((turn.T @ other_turn)[None])[0]
            yield Joint((first, second), ends, _rounded(rotation))

    def _near(self, link: _Link, pivot: FloatArray) -> list[tuple[str, FloatArray, FloatArray]]:
        """Of what a link is fixed to, the parts that reach to a pivot (3,) [m]: name, rotation
        (3, 3) at rest, and where it has the pivot."""
        root, found = self.root(link), []
        parts = self.parts.get(root, [])
        if root not in self._boxes:
            self._boxes[root] = np.array([self._box(part) for part in parts]).reshape(-1, 2, 3)
        gaps = (self._boxes[root] - pivot) * [[1], [-1]]
        beyond = gaps.max(axis=(1, 2))
        for row in np.flatnonzero(beyond <= self._reach).tolist():
            pose = rigid_transforms(self._place((parts[row], "")).T.reshape(1, 16))[0][0]
            turn = pose[:3, :3]
            found.append((parts[row].name_full, turn, turn.T @ (pivot - pose[:3, 3])))
        return found

    def _box(self, part: Object) -> FloatArray:
        """Least and largest coordinates (2, 3) of a part at rest [m]."""
        place = self._place((part, ""))
        corners = np.array(part.bound_box) @ place[:3, :3].T + place[:3, 3]
        return np.array([corners.min(axis=0), corners.max(axis=0)])

    def _place(self, link: _Link) -> FloatArray:
        """The world matrix (4, 4) of a link at rest [m]; not a number where nothing tells it."""
        obj, bone = link
        world = self._rest.world(obj)
        if world is None:
            return np.full((4, 4), np.nan)
        place = self._metres * world[0]
        return place @ np.array(obj.data.bones[bone].matrix_local) if bone else place


class _Rest(Curves):
    """World matrices at rest."""

    def _is_told(self, obj: Object) -> bool:
        return True

    def _bone(self, rig: Object, bone: PoseBone | None) -> FloatArray | None:
        return None if bone is None else np.array(bone.bone.matrix_local)

    def basis(self, owner: Object, item: Any, path: str) -> FloatArray:
        if owner.animation_data is None:
            return np.array(owner.matrix_basis)[None]
        found = super().basis(owner, item, path)
        if any(curve.data_path.startswith("rotation") for curve in driving_curves(owner)):
            found[:, :3, :3] = np.diag(item.scale)
        return found


def _above(link: _Link) -> _Link | None:
    """What carries a link; None if nothing does, or something that deforms itself."""
    obj, bone = link
    if bone:
        above = obj.data.bones[bone].parent
        return obj, above.name if above else ""
    parent = obj.parent
    if parent is not None and obj.parent_type == "BONE":
        return (parent, obj.parent_bone) if obj.parent_bone in parent.data.bones else None
    return (parent, "") if parent is not None and obj.parent_type == "OBJECT" else None


def _changes(curve: Any) -> bool:
    """Whether the value of a curve changes."""
    values = read_array(curve.keyframe_points, "co", 2)[:, 1].tolist() or [0.0]
    steady = max(values) - min(values) <= _STEADY and not (curve.driver or len(curve.modifiers))
    return not (curve.mute or steady)


def _rounded(values: FloatArray) -> tuple[float, ...]:
    return tuple((np.round(values, 6) + 0.0).tolist())
