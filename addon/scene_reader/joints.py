"""Joints of a scene: points about which bones, keys, drivers or constraints only turn one part of
it on another."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np
from bpy.types import Object, PoseBone, Scene
from numpy.typing import ArrayLike

from ...core.arrays import FloatArray
from ...core.contacts.shapes import quaternions
from ...core.scene.joint import Joint
from ..blender.compatibility import driving_curves
from ..blender.time import stretching
from ..blender.units import metres_per_unit
from .known_motion import Curves
from .linkage import Link, Linkage, constraints_of
from .world_transforms import apply_stretch, rigid_transforms

_PINS = ("FIXED", "HINGE", "POINT")
"""Types of rigid body constraints that keep a point of two bodies together."""
_SAMPLES = 9
"""Frames by which an axis is found."""
_ROUNDING = 1e-4
"""Change of a direction that is rounding."""


def joints_of(scene: Scene) -> tuple[Joint, ...]:
    """The joints between tagged objects. At rest, bones are where their armature has them, and
    objects where they are in the first frame, unturned where drivers turn them."""
    pins = constraints_of(scene)
    if not pins and not any(obj.parent for obj in scene.objects):
        return ()
    linkage, found = Linkage(), list[Joint]()
    parts: dict[Link, list[Object]] = {}
    for obj in scene.objects:
        if obj.haptics.enabled:
            parts.setdefault(linkage.root((obj, "")), []).append(obj)
    rest = _Rest(scene, parts)
    for link in parts:
        above = linkage.above(link)
        if above is not None and not linkage.moves(link):
            found += rest.joints(above, link, rest.axis(link))
    for pin, joint in pins:
        if joint.enabled and joint.type in _PINS:
            one, other = (linkage.root((body, "")) for body in (joint.object1, joint.object2))
            line = rest.place((pin, ""))[:3, [3, 2]].T * [[1], [joint.type == "HINGE"]]
            found += rest.joints(one, other, line)
    return tuple(found)


class _Rest(Curves):
    """A scene at rest. ``parts``: the tagged objects by their link."""

    def __init__(self, scene: Scene, parts: dict[Link, list[Object]]) -> None:
        super().__init__(scene.frame_start / stretching(scene) + np.arange(2.0))
        self._metres = metres_per_unit(scene)
        self._reach = scene.haptics.contact_tolerance
        self._parts = parts
        self._known: dict[Link, tuple[FloatArray, FloatArray]] = {}

    def joints(self, one: Link, other: Link, line: FloatArray) -> Iterator[Joint]:
        """The joints of the parts of two links that both reach to a ``line``, a point and a
        direction (2, 3): in the middle of where they do, or at the point if the direction is 0."""
        near = (self._near(link, line) for link in (one, other))
        for (first, turn, here, span), (second, turned, there, other_span) in product(*near):
            begin, end = max(span[0], other_span[0]), min(span[1], other_span[1])
            if begin <= end:
                way = np.array([1.0, (begin + end) / 2 if line[1].any() else 0.0])
                rotation = quaternions((turn.T @ turned)[None])[0]
                ends = _rounded(way @ here), _rounded(way @ there)
                yield Joint((first, second), ends, _rounded(rotation))

    def _near(self, link: Link, line: FloatArray) -> Iterator[tuple[str, Any, Any, Any]]:
        """The parts of a link that reach to a line: name, rotation (3, 3) at rest, the line in the
        part's space, and from and to where on it (2,)."""
        parts = self._parts.get(link, [])
        if link not in self._known:
            self._known[link] = self._bounds(parts)
        poses, bounds = self._known[link]
        lines = (line - poses[:, None, :3, 3] * [[1], [0]]) @ poses[:, :3, :3]
        with np.errstate(divide="ignore", invalid="ignore"):
            ways = (bounds - lines[:, :1]) / lines[:, 1:]
        spans = np.array([ways.min(axis=1).max(axis=1), ways.max(axis=1).min(axis=1)])
        reaches = (spans[0] <= spans[1]) & (spans[0] < np.inf) & (spans[1] > -np.inf)
        for k in np.flatnonzero(reaches).tolist():
            yield parts[k].name_full, poses[k, :3, :3], lines[k], spans[:, k]

    def _bounds(self, parts: list[Object]) -> tuple[FloatArray, FloatArray]:
        """Poses (n, 4, 4) at rest, and least and largest coordinates (n, 2, 3) within reach in
        these [m]."""
        poses, stretches = _rigid([self.place((part, "")) for part in parts])
        corners = [
            apply_stretch(np.array(part.bound_box), stretch)
            for part, stretch in zip(parts, stretches, strict=True)
        ]
        ends = [(c.min(axis=0) - self._reach, c.max(axis=0) + self._reach) for c in corners]
        return poses, np.array(ends).reshape(-1, 2, 3)

    def place(self, link: Link) -> FloatArray:
        """The world matrix (4, 4) of a link [m]; not a number where nothing tells it."""
        obj, bone = link
        world = self.world(obj)
        if world is None:
            return np.full((4, 4), np.nan)
        place = self._metres * world[0]
        return place @ np.array(obj.data.bones[bone].matrix_local) if bone else place

    def axis(self, link: Link) -> FloatArray:
        """The origin of a link, and the direction about which alone curves turn it, 0 if there is
        none (2, 3)."""
        obj, bone = link
        item, path = (obj.pose.bones[bone], f'pose.bones["{bone}"].') if bone else (obj, "")
        own = self._curves_of(obj).items()
        ranges = [c.range() for (name, _), c in own if name.startswith(f"{path}rotation")]
        place = self.place(link)
        line = np.array([place[:3, 3], np.zeros(3)])
        if ranges:
            frames = np.rint(np.linspace(np.min(ranges), np.max(ranges) + 1, _SAMPLES))
            turns = _rigid(Curves(frames).basis(obj, item, path))[0][:, :3, :3]
            changes = (turns[0].T @ turns - np.eye(3)).reshape(-1, 3)
            _, sizes, directions = np.linalg.svd(changes)
            if sizes[2] < _ROUNDING < sizes[1]:
                line[1] = _rigid([place])[0][0, :3, :3] @ directions[2]
        return line

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


def _rigid(places: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Rigid transforms and stretches of matrices (n, 4, 4)."""
    return rigid_transforms(np.reshape(places, (-1, 4, 4)).transpose(0, 2, 1).reshape(-1, 16))


def _rounded(values: FloatArray) -> tuple[float, ...]:
    return tuple((np.round(values, 6) + 0.0).tolist())
