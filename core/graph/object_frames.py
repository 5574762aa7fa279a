"""Frames of reference of objects: centres, axes and sizes of their bounding boxes, from shapes and
poses."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ..arrays import FloatArray, IntArray
from ..contacts.shapes import Shape, pose_matrix
from ..frozen import frozen
from ..scene.values import HapticObject, Pose

SHEET = 0.01
"""Least thickness [m] of a body whose edge a patch may fill: an edge of a thinner one is none."""


@frozen(eq=False)
class ObjectFrames:
    """``centre`` (n, 3) of each object's bounding box [m, world], NaN for an object without a
    shape; ``axes`` (n, 3, 3): the object's own axes as columns; ``size`` (n, 3): along these [m],
    NaN without a shape."""

    centre: FloatArray
    axes: FloatArray
    size: FloatArray

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, ObjectFrames)
            and np.array_equal(self.centre, other.centre, equal_nan=True)
            and np.array_equal(self.axes, other.axes)
            and np.array_equal(self.size, other.size, equal_nan=True)
        )

    @classmethod
    @lru_cache(maxsize=4)
    def unknown(cls, count: int) -> ObjectFrames:
        """Frames of objects without shapes, with the axes of the world."""
        centre = np.full((count, 3), np.nan)
        axes = np.tile(np.eye(3), (count, 1, 1))
        centre.setflags(write=False)
        axes.setflags(write=False)
        return cls(centre, axes, centre)

    @classmethod
    def of_objects(
        cls, objects: Sequence[HapticObject], transforms: FloatArray | None = None
    ) -> ObjectFrames:
        """Of a scene's objects in the order of their names, from their shapes and their
        ``transforms`` (n, 4, 4), by default their poses."""
        frames = cls.unknown(len(objects))
        order = sorted(range(len(objects)), key=lambda k: objects[k].name)
        shaped = [(number, k) for number, k in enumerate(order) if objects[k].shape is not None]
        if not shaped:
            return frames
        numbers, chosen = np.array(shaped).T
        return frames.placed(
            numbers,
            local_bounds([objects[k].shape for k in chosen]),
            np.array([pose_matrix(objects[k].pose or Pose()) for k in chosen])
            if transforms is None
            else transforms[chosen],
        )

    def turned(self, numbers: IntArray, transforms: FloatArray) -> ObjectFrames:
        """With the axes of objects ``numbers`` (k,) under rigid ``transforms`` (k, 4, 4)."""
        axes = self.axes.copy()
        axes[numbers] = transforms[:, :3, :3]
        return ObjectFrames(self.centre, axes, self.size)

    def placed(self, numbers: IntArray, bounds: FloatArray, transforms: FloatArray) -> ObjectFrames:
        """With objects ``numbers`` (k,) under rigid ``transforms`` (k, 4, 4), whose boxes have the
        local ``bounds`` (k, 2, 3)."""
        centre = self.centre.copy()
        axes = self.axes.copy()
        size = self.size.copy()
        low, high = bounds[:, 0], bounds[:, 1]
        size[numbers] = high - low
        turn = axes[numbers] = transforms[:, :3, :3]
        centre[numbers] = np.einsum("nij,nj->ni", turn, (low + high) / 2) + transforms[:, :3, 3]
        return ObjectFrames(centre, axes, size)

    def patch_sizes(self, pairs: IntArray, area: FloatArray, normal: FloatArray) -> FloatArray:
        """Sizes (k,) [m] of patches between objects (k, 2): the side of a square of their ``area``
        (k,) [m^2], or the length of one that is as wide as an object is thick; at most twice the
        width of either object, as waves run along what is longer. ``normal`` (k, 3): of the
        patches, in the world."""
        size = self.size[pairs]
        others = np.maximum(np.minimum(size[..., [1, 2, 0]], size[..., [2, 0, 1]]), SHEET)
        facing = (normal[:, None, :, None] * self.axes[pairs]).sum(axis=2) ** 2
        length = area * np.fmax.reduce((facing / others).sum(axis=2), axis=1)
        most = 2 * np.fmin.reduce(np.median(size, axis=2), axis=1)
        return np.asarray(np.fmin(np.fmax(np.sqrt(area), length), most))


def local_bounds(shapes: Sequence[Shape]) -> FloatArray:
    """Bounding boxes (n, 2, 3) of shapes in their own space."""
    return np.array([shape.local_bounds for shape in shapes], dtype=np.float64).reshape(-1, 2, 3)
