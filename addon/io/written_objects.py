"""The objects of a scene as its frames are written: with their shapes and poses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...core.arrays import BoolArray, FloatArray
from ...core.contacts.shapes import quaternions
from ...core.scene.values import HapticObject, Pose
from ..scene_reader.reading import Reading


class WrittenObjects:
    """Writes the objects of each frame of a scene. One that has neither changed nor moved since the
    last frame is written as the same value."""

    def __init__(self) -> None:
        self._reading: Reading | None = None
        self._objects: tuple[HapticObject, ...] = ()

    def of(self, reading: Reading) -> tuple[HapticObject, ...]:
        """The objects of a frame with the shapes and poses that they have in it."""
        changed = np.flatnonzero(self._changed(reading))
        objects = list(self._objects if len(changed) < len(reading.objects) else reading.objects)
        poses = _poses(reading.transforms[changed])
        for i, pose in zip(changed.tolist(), poses, strict=True):
            objects[i] = replace(reading.objects[i], shape=reading.bodies[i].shape, pose=pose)
        self._reading, self._objects = reading, tuple(objects)
        return self._objects

    def _changed(self, reading: Reading) -> BoolArray:
        """Which objects (n,) have changed or moved since the last frame."""
        last = self._reading
        if last is None or len(last.objects) != len(reading.objects):
            return np.ones(len(reading.objects), dtype=np.bool_)
        other = (
            item is not before or body.shape is not before_body.shape
            for item, before, body, before_body in zip(
                reading.objects, last.objects, reading.bodies, last.bodies, strict=True
            )
        )
        moved = (reading.transforms != last.transforms).any(axis=(1, 2))
        return np.fromiter(other, np.bool_, len(moved)) | moved


def _poses(transforms: FloatArray) -> Iterator[Pose]:
    """The poses of rigid transforms (n, 4, 4), in double precision."""
    turns = quaternions(transforms[:, :3, :3])
    for place, turn in zip(transforms[:, :3, 3].tolist(), turns.tolist(), strict=True):
        yield Pose(tuple(place), tuple(turn))
