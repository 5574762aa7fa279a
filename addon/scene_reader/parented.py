"""Corrects, to double precision, poses of children that do not move relative to their parents.

World matrices are of single precision: the pose of one link of a robot to another trembles by a ten
millionth while the robot moves, and each contact of the two would be computed again.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...core.arrays import FloatArray

_TREMBLES = 1e-6
"""Change of the pose to the parent, per metre from the world's origin, that is rounding."""


class ParentedPoses:
    """Keeps the poses of children to their parents free of rounding. ``carried``: number of the
    parent by number of the child, in the order of the poses."""

    def __init__(self, carried: Mapping[int, int]) -> None:
        self.carried = carried
        children, parents = np.array([*carried.items()], dtype=np.int64).reshape(-1, 2).T
        depth = np.zeros(len(children), dtype=np.int64)
        for k, parent in enumerate(carried.values()):
            while parent in carried:
                depth[k] += 1
                parent = carried[parent]
        order = np.argsort(depth, kind="stable")
        self._children = children[order]
        self._parents = parents[order]
        self._levels = np.split(np.arange(len(order)), np.flatnonzero(np.diff(depth[order])) + 1)
        self._all = np.union1d(children, parents)
        self._relative: FloatArray | None = None

    def correct(self, poses: FloatArray, exact: bool) -> None:
        """Correct rigid ``poses`` (m, 4, 4) in place: a child whose pose to its parent differs from
        that of the last frame by rounding alone gets exactly that pose. ``exact``: forget the poses
        of the last frame."""
        if len(self._children) == 0:
            return
        turns = poses[self._all, :3, :3]
        for _ in range(2):  # Newton's iteration to the nearest rotation
            squares = np.einsum("nji,njk->nik", turns, turns)
            turns = np.einsum("nij,njk->nik", turns, (3 * np.eye(3) - squares) / 2)
        poses[self._all, :3, :3] = turns
        now = _relative(poses[self._parents], poses[self._children])
        if exact or self._relative is None:
            self._relative = now
        far = 1.0 + np.abs(poses[self._children, :3, 3]).max(axis=1)
        moved = np.abs(now - self._relative).max(axis=(1, 2)) > _TREMBLES * far
        self._relative = np.where(moved[:, None, None], now, self._relative)
        for level in self._levels:
            poses[self._children[level]] = np.einsum(
                "nij,njk->nik", poses[self._parents[level]], self._relative[level]
            )


def _relative(first: FloatArray, second: FloatArray) -> FloatArray:
    """Poses (n, 4, 4) of ``second`` in the frames of ``first``, both (n, 4, 4)."""
    turns = first[:, :3, :3]
    found = np.zeros_like(first)
    found[:, :3, :3] = np.einsum("nji,njk->nik", turns, second[:, :3, :3])
    found[:, :3, 3] = np.einsum("nji,nj->ni", turns, second[:, :3, 3] - first[:, :3, 3])
    found[:, 3, 3] = 1.0
    return found
