"""Surfaces of cores as triangles: meshes, and hulls where they meet a mesh. What is inside a closed
one touches it down to a depth."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray, connected
from ...frozen import frozen
from .cores import Core, CoreTable
from .frames import dot
from .mesh_index import MeshIndex
from .triangles import unit_normals

_MOST_IN_PART = 16_384
"""Triangles of which FCL builds a tree at a time. It holds Python's lock meanwhile, for about 3
microseconds a triangle, and Blender isn't drawn."""

_ROUNDING = 1e-6
"""Metres by which distances of bounds are reduced, so that rounding leaves them lower bounds."""


@frozen
class SurfacePart:
    """Neighbouring triangles of a surface, or a whole body, within the bounds ``low`` and ``high``
    (3,). ``first`` and ``second``: FCL's objects for the first and the second of a pair."""

    low: FloatArray
    high: FloatArray
    first: Any
    second: Any

    @classmethod
    def of(cls, points: FloatArray, triangles: IntArray) -> SurfacePart:
        """The part of ``triangles`` (t, 3) between ``points`` (n, 3)."""
        import fcl

        geometry = fcl.BVHModel()
        geometry.beginModel(len(points), len(triangles))
        geometry.addSubModel(points, triangles)
        geometry.endModel()
        return cls(
            points.min(axis=0),
            points.max(axis=0),
            fcl.CollisionObject(geometry),
            fcl.CollisionObject(geometry),
        )

    def distance_from_bounds(
        self, other: SurfacePart, rotation: FloatArray, offset: FloatArray
    ) -> float:
        """A lower bound on the distance [m] of another part, placed by ``rotation`` (3, 3) and
        ``offset`` (3,) in the frame of this one."""
        centre = rotation @ (other.low + other.high) / 2 + offset
        half = np.abs(rotation) @ (other.high - other.low) / 2
        apart = np.maximum(self.low - centre - half, centre - half - self.high)
        return float(np.linalg.norm(np.maximum(apart - _ROUNDING, 0.0)))


@frozen
class CoreSurface:
    """The triangles of a core in its own frame, by their bounds: their ``corners`` (3, 3, t) by
    coordinate and corner and, without repetition, ``points`` (n, 3); their ``middles`` (3, t) and
    the radii (t,) of spheres around these, and unit ``normals`` (3, t).
    ``piece`` (t,): the number of the connected piece that each belongs to, of ``pieces``.
    ``depth`` [m]: how far beneath the surface a body touches it; 0 of a shell, infinite of a hull.
    ``size`` [m]: the smallest extent of a solid, infinite of a shell."""

    index: MeshIndex
    corners: FloatArray
    middles: FloatArray
    radii: FloatArray
    normals: FloatArray
    low: FloatArray
    high: FloatArray
    points: FloatArray
    piece: IntArray
    pieces: int
    depth: float
    size: float
    parts: tuple[SurfacePart, ...]

    @classmethod
    def of(cls, core: Core) -> CoreSurface:
        """The surface of a mesh or a hull."""
        if core.mesh is not None:
            points, triangles, depth = core.mesh.points, core.mesh.triangles, core.sunk_in
        else:
            assert core.hull is not None
            points, triangles, depth = core.hull.points, core.hull.triangles, core.sunk_in
        if depth > 0 and np.linalg.matrix_rank(points - points[0], tol=1e-9 * np.ptp(points)) < 3:
            depth = 0.0  # flat
            if core.mesh is None:  # whose hull has both sides
                across = unit_normals(points[triangles].transpose(2, 1, 0))
                triangles = triangles[dot(across, across[:, :1]) > 0]
        low, high = core.bounds()
        size = float(np.min(high - low)) + 2 * core.radius[0] if depth > 0 else np.inf
        index = MeshIndex.of(points[triangles])
        corners = np.ascontiguousarray(index.corners.transpose(2, 1, 0))
        middles = corners.mean(axis=1)
        piece, pieces = _pieces(points, triangles[index.number])
        return cls(
            index,
            corners,
            middles,
            np.sqrt(((corners - middles[:, None]) ** 2).sum(axis=0).max(axis=0)),
            unit_normals(corners),
            low,
            high,
            points[np.unique(triangles)],
            piece,
            pieces,
            depth,
            size,
            tuple(_parts(points, triangles, index.number)),
        )

    def contains(self, points: FloatArray) -> BoolArray:
        """Which points (n, 3) are inside: where the surface winds around them, counted along rays
        upwards. A point on the edge of two triangles, seen from above, counts for one of them."""
        bounds = np.stack([points, points], axis=1)
        bounds[:, 1, 2] = np.inf
        ray, triangle = self.index.near(bounds)
        corners = self.index.corners[triangle] - points[ray, None]
        a = corners[:, 0]
        b = corners[:, 1]
        c = corners[:, 2]
        sides = np.stack([_side(p, q) for p, q in ((a, b), (b, c), (c, a))])
        turns = np.where((sides > 0).all(axis=0), 1, np.where((sides < 0).all(axis=0), -1, 0))
        normal = np.cross(b - a, c - a)
        above = (normal * a).sum(axis=1) * turns > 0
        return np.bincount(ray[above], turns[above], len(points)) > 0.5


def _parts(points: FloatArray, triangles: IntArray, order: IntArray) -> Iterator[SurfacePart]:
    """Parts of at most `_MOST_IN_PART` triangles that are neighbours in ``order``."""
    for part in np.array_split(order, math.ceil(len(order) / _MOST_IN_PART)):
        used, corners = np.unique(triangles[np.sort(part)], return_inverse=True)
        yield SurfacePart.of(points[used], corners.reshape(-1, 3))


def _pieces(points: FloatArray, triangles: IntArray) -> tuple[IntArray, int]:
    """The connected components of a mesh: the number (t,) of that of each triangle, and how many
    there are. Triangles that have a vertex at the same place are connected."""
    order = np.lexsort(points.T)
    apart = (points[order[1:]] != points[order[:-1]]).any(axis=1)
    place = np.zeros(len(points), dtype=np.int64)
    place[order[1:]] = apart.cumsum()
    corners = place[triangles]
    label = connected(corners[:, [0, 1, 1, 2]].reshape(-1, 2), len(points))
    first, piece = np.unique(label[corners[:, 0]], return_inverse=True)
    return piece, len(first)


def _side(start: FloatArray, end: FloatArray) -> IntArray:
    """On which side of each edge (n, 3), seen from above, the origin is: 1 or -1; the opposite for
    the edge in the other direction."""
    area = start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]
    way = end - start
    return np.sign(
        np.where(area != 0, area, np.where(way[:, 1] != 0, way[:, 1], way[:, 0]))
    ).astype(np.int64)


class Surfaces:
    """The surfaces of a table's cores, made on first use."""

    def __init__(self, table: CoreTable) -> None:
        self._table = table
        self._made: dict[int, CoreSurface] = {}  # by the id of the core: equal bodies share theirs

    def take_over(self, before: Surfaces) -> None:
        """Keep the surfaces of those cores that are in this table, too."""
        self._made = {
            id(core): before._made[id(core)]
            for core in self._table.cores
            if id(core) in before._made
        }

    def __getitem__(self, core: int) -> CoreSurface:
        item = self._table.cores[core]
        made = self._made.get(id(item))
        if made is None:
            made = self._made[id(item)] = CoreSurface.of(item)
        return made
