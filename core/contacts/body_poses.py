"""The poses of bodies in the current frame, the bounding boxes there, and what has changed since
the last frame."""

from __future__ import annotations

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, carried
from .body_table import BodyTable

_COLUMNS = np.array([0, 1, 2, 4, 5, 6, 8, 9, 10, 3, 7, 11])
"""Indices of the rotation and then the position in the upper three rows of a 4 x 4 matrix."""


def columns_of(transforms: FloatArray) -> FloatArray:
    """Rigid transforms (n, 4, 4) as poses (12, n)."""
    return np.ascontiguousarray(transforms.reshape(-1, 16)[:, _COLUMNS].T)


class BodyPoses:
    """Poses of n bodies, none of which is placed at first.

    Attributes:
        pose: (12, n) rotation by rows, then position; NaN for a body that is left out.
        version: (n,) how often the pose or the shape of each has changed.
        extents: (2, 3, n) of the bounding boxes in the world, against and along the axes, grown so
            that they overlap wherever two bodies can touch; -infinite of a body that is left out.
        last_extents: (2, 3, n) the same in the last frame.
    """

    def __init__(self, count: int) -> None:
        self.pose = np.full((12, count), np.nan)
        self._rest_pose = self.pose.copy()
        self.version = np.zeros(count, dtype=np.int64)
        self.extents = self.last_extents = np.full((2, 3, count), -np.inf)

    def place(
        self, table: BodyTable, transforms: FloatArray, grow: float
    ) -> tuple[FloatArray, IntArray, IntArray, IntArray]:
        """Place the bodies of ``table`` by ``transforms`` (n, 4, 4).

        Returns:
            The poses (12, n), NaN or infinite where they are; the numbers of the bodies whose pose
            has changed; of those that have left the place where they rested; of those that are left
            out from now on.
        """
        columns = columns_of(transforms)
        moved = (columns != self.pose).any(axis=0).nonzero()[0]
        if len(moved) == 0:
            self.last_extents = self.extents
            return columns, moved, moved, moved
        self.last_extents = self.extents.copy()
        finite = np.isfinite(columns.take(moved, axis=1)).all(axis=0)
        lost = gone = moved[~finite]
        if len(lost):
            moved = moved[finite]
            gone = lost[np.isfinite(self.pose[0, lost])]
            self.extents[..., gone] = -np.inf
            self.version[gone] += 1
            self.pose[:, lost] = self._rest_pose[:, lost] = np.nan
        pose = self.pose[:, moved] = columns.take(moved, axis=1)
        way = np.abs(pose - self._rest_pose.take(moved, axis=1))
        left = moved[~(way <= table.rest_limits.take(moved, axis=1)).all(axis=0)]
        self._rest_pose[:, left] = columns.take(left, axis=1)
        self.version[moved] += 1
        self.extents[..., moved] = table.extents(moved, pose, grow)
        if len(gone):
            moved = np.union1d(moved, gone)
        return columns, moved, left, lost

    def rest_here(self) -> None:
        """Count all bodies as at rest where they are."""
        self._rest_pose[:] = self.pose

    def forget(self, bodies: BoolArray) -> None:
        """Count the next poses of ``bodies`` (n,), which have changed, as their first ones."""
        self.pose[:, bodies] = self._rest_pose[:, bodies] = np.nan
        self.version[bodies] += 1

    def renumber(self, before: IntArray) -> None:
        """Follow a new order of the bodies: ``before`` (n,) are their former numbers, -1 for a new
        one."""
        self.pose, self._rest_pose = (
            carried(poses, before, np.nan) for poses in (self.pose, self._rest_pose)
        )
        self.version = carried(self.version, before, 0)
        self.extents, self.last_extents = (
            carried(extents, before, -np.inf) for extents in (self.extents, self.last_extents)
        )
