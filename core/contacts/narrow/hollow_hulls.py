"""Bodies deep in convex hulls that stand for closed surfaces: such a hull is a wall as thick as
bodies may sink in, not a solid."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...arrays import FloatArray, IntArray
from ..hull import convex_hull
from ..shapes import ConvexHull, Shape
from .body_patches import PairPatches
from .convex import ConvexDistances
from .cores import CoreTable, Size
from .manifold import UNEVEN

_SAME = 1e-9
"""Tolerance with which a depth counts as the largest allowed one [m]: contacts with triangles are
no deeper."""


class HollowHulls:
    """Limits the depth of contacts of the ``shapes`` that are such hulls, and drops what is deeper
    inside."""

    def __init__(self, shapes: Sequence[Shape], table: CoreTable, bodies: ConvexDistances) -> None:
        self._shapes = shapes
        self._table = table
        self._bodies = bodies
        self._depth = np.array(
            [
                np.inf if not isinstance(s, ConvexHull) or s.sunk_in is None else s.sunk_in
                for s in shapes
            ]
        )
        self._size = np.zeros(len(shapes))
        self._any = bool(np.isfinite(self._depth).any())
        if self._any:
            self._size[:] = [np.ptp(s.local_bounds, axis=0).min() for s in shapes]

    def measure(self, body: int, bounds: FloatArray) -> None:
        """Set the size of a body with local ``bounds`` (2, 3)."""
        if self._any:
            self._size[body] = np.ptp(bounds, axis=0).min()

    def limit(
        self, pairs: IntArray, rotation: FloatArray, offset: FloatArray, found: PairPatches
    ) -> None:
        """Correct the patches ``found`` of ``pairs`` (p, 2), placed as in `NarrowPhase`, in
        place."""
        if not self._any:
            return
        depth = self._depth[pairs].min(axis=1)
        most = np.minimum(depth, self._size[pairs].min(axis=1) / 2)
        for k in np.flatnonzero(np.isfinite(depth) & (found.distance < _SAME - most)).tolist():
            found.distance[k] = -most[k]
            turn = rotation[..., k]
            place = offset[:, k]
            for outer, inner, way, shift, sign in (
                (*pairs[k].tolist(), turn, place, 1.0),
                (*pairs[k, ::-1].tolist(), turn.T, -turn.T @ place, -1.0),
            ):
                if np.isinf(self._depth[outer]):
                    continue
                normals, offsets = self._planes(outer)
                gaps = offsets - self._reaches(inner, normals @ way) - normals @ shift
                nearest = int(gaps.argmin())
                if gaps[nearest] > 0:
                    normal = normals[nearest]
                    centre = (
                        way @ self._end(inner, normal @ way) + shift + normal * (gaps[nearest] / 2)
                    )
                    found.distance[k] = gaps[nearest] - most[k]
                    found.normal[:, k] = sign * (normal if sign > 0 else turn @ normal)
                    found.centre[:, k] = centre if sign > 0 else turn @ centre + place
                    found.area[k] = 0.0

    def _planes(self, body: int) -> tuple[FloatArray, FloatArray]:
        """Outward unit normals (f, 3) and offsets (f,) of the faces of such a hull."""
        shape = self._shapes[body]
        assert isinstance(shape, ConvexHull)
        normals, offsets = convex_hull(shape.points).planes()
        return normals, offsets + shape.margin

    def _cores(self, body: int) -> range:
        return range(int(self._table.start[body]), int(self._table.start[body + 1]))

    def _reaches(self, body: int, directions: FloatArray) -> FloatArray:
        """How far a body extends along unit ``directions`` (m, 3) in its own space, (m,)."""
        reach = np.full(len(directions), -np.inf)
        for core in self._cores(body):
            own = directions @ self._table.rotation[..., core]
            far = self._bodies.core(core, Size.USUAL).support(own)
            np.maximum(
                reach,
                far
                + directions @ self._table.offset[:, core]
                + self._table.radius[Size.USUAL, core],
                out=reach,
            )
        return reach

    def _end(self, body: int, direction: FloatArray) -> FloatArray:
        """The middle of what of a body is farthest along a unit direction: of its corners, those
        that are hardly less far count less."""
        places = []
        heights = []
        for core in self._cores(body):
            turn = self._table.rotation[..., core]
            place = self._table.offset[:, core]
            radius = self._table.radius[Size.USUAL, core]
            corners = self._bodies.core(core, Size.USUAL).corners(turn.T @ direction)
            at = corners @ turn.T + place + radius * direction
            places.append(at)
            heights.append(at @ direction)
        every = np.concatenate(places)
        height = np.concatenate(heights)
        weight = np.clip(1.0 - (height.max() - height) / UNEVEN, 0.0, None) ** 2
        return np.asarray(weight @ every / weight.sum())
