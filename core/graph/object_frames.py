"""Frames of reference of objects: centres and axes of their bounding boxes, from shapes and
poses."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ..arrays import FloatArray, IntArray
from ..contacts.shapes import Shape, pose_matrix
from ..frozen import frozen
from ..scene.values import HapticObject, Pose


@frozen(eq=False)
class ObjectFrames:
    """``centre`` (n, 3) of each object's bounding box [m, world], NaN for an object without a
    shape; ``axes`` (n, 3, 3): the object's own axes as columns."""

    centre: FloatArray
    axes: FloatArray

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, ObjectFrames)
            and np.array_equal(self.centre, other.centre, equal_nan=True)
            and np.array_equal(self.axes, other.axes)
        )

    @classmethod
    @lru_cache(maxsize=4)
    def unknown(cls, count: int) -> ObjectFrames:
        """Frames of objects without shapes, with the axes of the world."""
        centre = np.full((count, 3), np.nan)
        axes = np.tile(np.eye(3), (count, 1, 1))
        centre.setflags(write=False)
        axes.setflags(write=False)
        return cls(centre, axes)

    @classmethod
    def of_objects(cls, objects: Sequence[HapticObject]) -> ObjectFrames:
        """From the shapes and poses of a scene's objects."""
        frames = cls.unknown(len(objects))
        shaped = [number for number, item in enumerate(objects) if item.shape is not None]
        if not shaped:
            return frames
        transforms = np.array([pose_matrix(objects[number].pose or Pose()) for number in shaped])
        return frames.placed(
            np.array(shaped),
            local_centres([objects[number].shape for number in shaped]),
            transforms,
        )

    def placed(
        self, numbers: IntArray, centres: FloatArray, transforms: FloatArray
    ) -> ObjectFrames:
        """With objects ``numbers`` (k,) under rigid ``transforms`` (k, 4, 4), the middle of each
        box at local ``centres`` (k, 3)."""
        centre = self.centre.copy()
        axes = self.axes.copy()
        axes[numbers] = transforms[:, :3, :3]
        centre[numbers] = (transforms[:, :3, :3] * centres[:, None]).sum(axis=2) + transforms[
            :, :3, 3
        ]
        return ObjectFrames(centre, axes)


def local_centres(shapes: Sequence[Shape]) -> FloatArray:
    """Middles (n, 3) of the bounding boxes of shapes in their own space."""
    return np.array(
        [shape.local_bounds().mean(axis=0) for shape in shapes], dtype=np.float64
    ).reshape(-1, 3)
