"""Motion of keyed bodies between two frames, from their F-curves and those of what they are
parented to."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
from bpy.types import Object, PoseBone, Scene

from ...core.arrays import FloatArray, carried
from ...core.contacts.known_motion import KnownMotion
from ...core.contacts.settings import Motion
from ...core.contacts.shapes import rotation_matrix, transformed_bounds
from ..blender.compatibility import fcurves_of
from ..blender.full_names import object_named
from ..blender.time import frame_seconds, stretching
from ..blender.units import metres_per_unit
from .reading import Reading
from .world_transforms import in_metres, rigid_transforms

_STEP = 0.00065
"""Longest time between two samples [s]."""
_NEAR = 0.1
"""Metres from other bodies within which one may strike."""
_SAME = 1e-4
"""Difference of poses, relative to the largest coordinate, up to which curves lead to a pose."""


def known_motion(
    scene: Scene, since: int, frame: int, before: Reading, now: Reading, last: KnownMotion | None
) -> KnownMotion | None:
    """The motion from the frame ``since``, whose reading is ``before``, to a ``frame`` of the
    bodies that may strike others, and whose curves tell it; None if there are none. ``last``: the
    one before, because what it tells of has come to rest in between."""
    if not len(now.bodies) or since >= frame:
        return None
    known = transforms_before(before, now)
    rows = _striking(known, now, _moving(last))
    if not len(rows):
        return None
    seconds = (frame - since) * frame_seconds(scene)
    count = 8 * max(2, int(np.ceil(seconds / _STEP / 8)))
    parts = np.arange(-2, count + 1) / count
    frames = (since + parts * (frame - since)) / stretching(scene)
    curves = Curves(frames)
    metres = metres_per_unit(scene)
    found = {}
    for row in rows.tolist():
        name = now.bodies[row].name
        obj = object_named(name)
        world = None if obj is None else curves.world(obj)
        if world is None:
            continue
        raw = world.transpose(0, 2, 1).reshape(-1, 16)
        poses, _ = rigid_transforms(in_metres(raw, metres))
        ends = np.stack([known[row], now.transforms[row]])
        if np.abs(poses[[2, -1]] - ends).max() <= _SAME * max(1.0, np.abs(ends).max()):
            found[name] = poses
    return KnownMotion(seconds / count, found) if found else None


def transforms_before(before: Reading, now: Reading) -> FloatArray:
    """The transforms (n, 4, 4) ``before`` of the bodies of ``now``, NaN of new ones."""
    if before.objects is now.objects:
        return before.transforms
    number = {body.name: k for k, body in enumerate(before.bodies)}
    rows = np.array([number.get(body.name, -1) for body in now.bodies], dtype=np.int64)
    return carried(before.transforms.transpose(1, 2, 0), rows, np.nan).transpose(2, 0, 1)


def _moving(motion: KnownMotion | None) -> frozenset[str]:
    """The names of the bodies that a motion moves."""
    poses = {} if motion is None else motion.poses
    return frozenset(name for name, way in poses.items() if (way[3:] != way[2:-1]).any())


def _striking(known: FloatArray, now: Reading, last: frozenset[str]) -> FloatArray:
    """The rows of the bodies near others that animation has moved since the frame before, where
    they were at ``known``, or those up to it that are among ``last``, by name."""
    moved = (known != now.transforms).any(axis=(1, 2))
    moved |= [body.name in last for body in now.bodies]
    moved &= np.isfinite(known).all(axis=(1, 2))
    moved &= [body.motion is Motion.KINEMATIC and bool(body.mass) for body in now.bodies]
    rows = moved.nonzero()[0]
    if not len(rows):
        return rows
    local = np.array([body.shape.local_bounds for body in now.bodies])
    then = np.where(np.isfinite(known), known, now.transforms)
    low, high = np.stack(
        [transformed_bounds(local, poses) for poses in (then, now.transforms)], axis=1
    ).transpose(2, 1, 0, 3)
    low, high = low.min(axis=0), high.max(axis=0)
    reach = _NEAR + (high - low)[rows] / 2  # curves swing further than their frames show
    meets = (low[rows, None] - reach[:, None] <= high) & (high[rows, None] + reach[:, None] >= low)
    return rows[meets.all(axis=2).sum(axis=1) > 1]  # each meets itself


def is_simulated(obj: Object) -> bool:
    """Whether an object is where a simulation takes it."""
    body = obj.rigid_body
    return body is not None and body.type == "ACTIVE" and not body.kinematic


_EXACT = 1e-7
"""Difference, relative to the largest value, up to which a polynomial is a curve: that of single
precision."""


class Curves:
    """World matrices at ``frames`` (k,), each computed once; None of what something else than
    curves may move."""

    def __init__(self, frames: FloatArray) -> None:
        self._frames = frames
        self._worlds: dict[str, FloatArray | None] = {}
        self._values: dict[str, dict[tuple[str, int], Any]] = {}

    def world(self, obj: Object) -> FloatArray | None:
        """World matrices (k, 4, 4) of an object."""
        line = [obj]
        while line[-1].parent is not None and line[-1].name_full not in self._worlds:
            line.append(line[-1].parent)
        for each in reversed(line):
            if each.name_full not in self._worlds:
                self._worlds[each.name_full] = self._world(each)
        return self._worlds[obj.name_full]

    def _is_told(self, obj: Object) -> bool:
        """Whether curves tell where an object is on its parent."""
        return not (is_simulated(obj) or any(not item.mute for item in obj.constraints))

    def _world(self, obj: Object) -> FloatArray | None:
        if not self._is_told(obj):
            return None
        local = self.basis(obj, obj, "")
        parent = obj.parent
        if parent is None:
            return local
        above = self.world(parent)
        if above is not None and obj.parent_type == "BONE":
            bone = self._bone(parent, parent.pose.bones.get(obj.parent_bone))
            if bone is None:
                return None
            tail = np.eye(4)
            tail[1, 3] = parent.data.bones[obj.parent_bone].length
            above = above @ bone @ tail
        elif obj.parent_type != "OBJECT":
            return None
        return None if above is None else above @ np.array(obj.matrix_parent_inverse) @ local

    def _bone(self, rig: Object, bone: PoseBone | None) -> FloatArray | None:
        """Matrices (k, 4, 4) of a bone in its armature's space."""
        if bone is None:
            return None
        found = np.eye(4)[None]
        chain = [bone, *bone.parent_recursive]
        for part, above in pairwise([*chain, None]):
            assert part is not None
            plain = part.bone.use_inherit_rotation and part.bone.inherit_scale == "FULL"
            if not plain or any(not item.mute for item in part.constraints):
                return None
            rest = np.array(part.bone.matrix_local)
            if above is not None:
                rest = np.linalg.inv(np.array(above.bone.matrix_local)) @ rest
            path = f'pose.bones["{part.name}"].'
            found = rest @ self.basis(rig, part, path) @ found
        return found

    def basis(self, owner: Object, item: Any, path: str) -> FloatArray:
        """Local matrices (k, 4, 4) of an object or a bone ``item``, whose curves the ``owner`` has
        under ``path``."""

        def channel(name: str) -> FloatArray:
            values = np.array(getattr(item, name), dtype=np.float64)
            rows = np.tile(values, (len(self._frames), 1))
            for index in range(len(values)):
                curve = self._curves_of(owner).get((path + name, index))
                if curve is not None:
                    rows[:, index] = self._evaluated(curve)
            return rows

        found = np.tile(np.eye(4), (len(self._frames), 1, 1))
        found[:, :3, :3] = _turns(item.rotation_mode, channel) * channel("scale")[:, None]
        found[:, :3, 3] = channel("location")
        return found

    def _evaluated(self, curve: Any) -> FloatArray:
        """Values (k,) of a curve: from the third on by the polynomial of least degree through some
        of them, if it meets more of them than it has coefficients."""
        if len(self._frames) < 16:
            return _sampled(curve, self._frames)
        nodes, fits = _polynomials(len(self._frames) - 2)
        some = _sampled(curve, self._frames[2:][nodes])
        error = _EXACT * max(1.0, np.abs(some).max())
        for fit in fits:
            smooth = fit @ some
            if np.abs(smooth[nodes] - some).max() <= error:
                return np.concatenate([_sampled(curve, self._frames[:2]), smooth])
        return _sampled(curve, self._frames)

    def _curves_of(self, owner: Object) -> dict[tuple[str, int], Any]:
        """The F-curves of an object by path and index."""
        if owner.name_full not in self._values:
            self._values[owner.name_full] = {
                (curve.data_path, curve.array_index): curve
                for curve in fcurves_of(owner)
                if not curve.mute
            }
        return self._values[owner.name_full]


def _sampled(curve: Any, frames: FloatArray) -> FloatArray:
    """Values (k,) of a curve at ``frames`` (k,), of which Blender knows only single precision: a
    share of a sample late in a scene."""
    single = frames.astype(np.float32).astype(np.float64)
    values = np.array([curve.evaluate(frame) for frame in single.tolist()])
    if np.array_equal(single, frames):
        return values
    return np.asarray(values + np.gradient(values, frames) * (frames - single))


@cache
def _polynomials(count: int) -> tuple[list[int], list[FloatArray]]:
    """Numbers of m samples among ``count`` even ones, denser towards the ends, and matrices
    (count, m) from values there to those at all samples, by least squares and polynomials of
    increasing degrees: a low one doesn't follow the roundings of values."""
    nodes = np.unique(np.rint((1 - np.cos(np.linspace(0, np.pi, 13))) / 2 * (count - 1))).astype(
        int
    )
    powers = np.polynomial.chebyshev.chebvander(np.linspace(-1, 1, count), 8)
    fits = [powers[:, :k] @ np.linalg.pinv(powers[nodes, :k]) for k in (2, 4, 9)]
    return nodes.tolist(), fits


def _turns(mode: str, channel: Callable[[str], FloatArray]) -> FloatArray:
    """Rotations (k, 3, 3) by the values that Blender has for a mode."""
    if mode == "QUATERNION":
        quaternion = channel("rotation_quaternion")
    elif mode == "AXIS_ANGLE":
        angle, *direction = channel("rotation_axis_angle").T
        way = np.array(direction) / np.maximum(np.linalg.norm(direction, axis=0), 1e-12)
        quaternion = np.array([np.cos(angle / 2), *(way * np.sin(angle / 2))]).T
    else:
        found = np.eye(3)[None]
        for axis_name in mode:
            axis = "XYZ".index(axis_name)
            half = channel("rotation_euler")[:, axis] / 2
            turn = np.zeros((len(half), 4))
            turn[:, 0], turn[:, 1 + axis] = np.cos(half), np.sin(half)
            found = rotation_matrix(turn) @ found
        return found
    length = np.linalg.norm(quaternion, axis=1, keepdims=True)
    return rotation_matrix(quaternion / np.maximum(length, 1e-12))
