"""Triangles of a mesh near a box, found by the bounds of blocks of neighbouring triangles."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray, IntArray
from ...frozen import frozen

_CHUNK = 2_000_000
"""Boxes times blocks or triangles tested at a time, to bound memory."""


@frozen
class MeshIndex:
    """``corners`` (t, 3, 3) of the triangles in the order of the blocks, of which each has as many,
    and their bounds ``low`` and ``high`` (3, b, size), filled up with such that overlap nothing;
    bounds of blocks (b, 3); the triangles' numbers in the mesh, ``number`` (t,)."""

    number: IntArray
    corners: FloatArray
    low: FloatArray
    high: FloatArray
    block_low: FloatArray
    block_high: FloatArray

    @classmethod
    def of(cls, corners: FloatArray) -> MeshIndex:
        """Index triangles (t, 3, 3), ordered along a Z-order curve so that neighbours share
        blocks."""
        centre = corners.mean(axis=1)
        extent = np.maximum(np.ptp(centre, axis=0), 1e-300)
        cell = np.minimum((centre - centre.min(axis=0)) / extent * 1024, 1023).astype(np.int64)
        order = np.argsort(_interleaved(cell), kind="stable")
        corners = corners[order]
        low = corners.min(axis=1)
        high = corners.max(axis=1)
        size = max(8, int(len(corners) ** 0.5 / 2))
        filled = (0, -len(corners) % size), (0, 0)
        low, high = (
            np.pad(bound, filled, constant_values=beyond).T.reshape(3, -1, size)
            for bound, beyond in ((low, np.inf), (high, -np.inf))
        )
        return cls(order, corners, low, high, low.min(axis=2).T.copy(), high.max(axis=2).T.copy())

    def near(self, bounds: FloatArray) -> tuple[IntArray, IntArray]:
        """Pairs of boxes ``bounds`` (n, 2, 3) [local space] and triangles with overlapping bounds:
        numbers of both, sorted."""
        boxes = [np.zeros(0, dtype=np.int64)]
        triangles = [np.zeros(0, dtype=np.int64)]
        step = max(1, _CHUNK // max(len(self.block_low), 1))
        for begin in range(0, len(bounds), step):
            box, block = _overlapping(bounds[begin : begin + step], self.block_low, self.block_high)
            box += begin
            most = max(1, _CHUNK // self.low.shape[2])
            for part in range(0, len(box), most):
                chosen = slice(part, part + most)
                found = self._in_blocks(bounds, box[chosen], block[chosen])
                boxes.append(found[0])
                triangles.append(found[1])
        return np.concatenate(boxes), np.concatenate(triangles)

    def _in_blocks(
        self, bounds: FloatArray, box: IntArray, block: IntArray
    ) -> tuple[IntArray, IntArray]:
        kept = np.ones((len(box), self.low.shape[2]), dtype=np.bool_)
        for low, high, bound in zip(self.low, self.high, bounds[box].T, strict=True):
            kept &= low[block] <= bound[1, :, None]
            kept &= high[block] >= bound[0, :, None]
        row, place = kept.nonzero()
        return box[row], block[row] * self.low.shape[2] + place


def _overlapping(
    bounds: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[IntArray, IntArray]:
    overlap = np.ones((len(bounds), len(low)), dtype=np.bool_)
    for axis in range(3):
        overlap &= low[None, :, axis] <= bounds[:, None, 1, axis]
        overlap &= high[None, :, axis] >= bounds[:, None, 0, axis]
    first, second = np.nonzero(overlap)
    return first.astype(np.int64), second.astype(np.int64)


def _interleaved(cell: IntArray) -> IntArray:
    """Z-order codes: the interleaved bits of three 10-bit numbers."""
    code = np.zeros(len(cell), dtype=np.int64)
    for bit in range(10):
        for axis in range(3):
            code |= ((cell[:, axis] >> bit) & 1) << (3 * bit + axis)
    return code
