"""Triangles of a mesh near a box, found by the bounds of blocks of neighbouring triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, IntArray

_CHUNK = 2_000_000
"""Boxes times blocks or triangles tested at a time, to bound memory."""


@dataclass(frozen=True, slots=True)
class MeshIndex:
    """``corners`` (t, 3, 3) of the triangles in the order of the blocks; bounds of
    blocks (b, 2, 3), the triangles of block k being ``k * size : (k + 1) * size``."""

    corners: FloatArray
    low: FloatArray
    high: FloatArray
    block_low: FloatArray
    block_high: FloatArray
    size: int

    @classmethod
    def of(cls, corners: FloatArray) -> MeshIndex:
        """Order triangles (t, 3, 3) along a Z-order curve."""
        centre = corners.mean(axis=1)
        extent = np.maximum(np.ptp(centre, axis=0), 1e-300)
        cell = np.minimum((centre - centre.min(axis=0)) / extent * 1024, 1023).astype(np.int64)
        order = np.argsort(_interleaved(cell), kind="stable")
        corners = corners[order]
        low, high = corners.min(axis=1), corners.max(axis=1)
        size = max(8, int(len(corners) ** 0.5 / 2))
        starts = np.arange(0, len(corners), size)
        return cls(
            corners,
            low,
            high,
            np.minimum.reduceat(low, starts),
            np.maximum.reduceat(high, starts),
            size,
        )

    def near(self, bounds: FloatArray) -> tuple[IntArray, IntArray]:
        """Pairs of boxes ``bounds`` (n, 2, 3) [local space] and triangles with overlapping bounds:
        numbers of both, sorted."""
        boxes, triangles = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
        step = max(1, _CHUNK // max(len(self.block_low), 1))
        for begin in range(0, len(bounds), step):
            box, block = _overlapping(bounds[begin : begin + step], self.block_low, self.block_high)
            box += begin
            for part in range(0, len(box), max(1, _CHUNK // self.size)):
                chosen = slice(part, part + max(1, _CHUNK // self.size))
                found = self._in_blocks(bounds, box[chosen], block[chosen])
                boxes.append(found[0])
                triangles.append(found[1])
        return np.concatenate(boxes), np.concatenate(triangles)

    def _in_blocks(
        self, bounds: FloatArray, box: IntArray, block: IntArray
    ) -> tuple[IntArray, IntArray]:
        triangle = (block[:, None] * self.size + np.arange(self.size)).reshape(-1)
        owner = np.repeat(box, self.size)
        real = triangle < len(self.corners)
        triangle, owner = triangle[real], owner[real]
        kept = (
            (self.low[triangle] <= bounds[owner, 1]) & (self.high[triangle] >= bounds[owner, 0])
        ).all(axis=1)
        return owner[kept], triangle[kept]


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
