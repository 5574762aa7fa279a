"""Convex hulls of points in space (quickhull), their faces, and hulls moved inwards by a margin."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..arrays import FloatArray, IntArray
from ..frozen import frozen
from .polytope import Polytope

MAX_HULL_POINTS = 2048
"""Most points a hull is computed from exactly; more are first reduced to the extreme ones in as
many directions."""


@frozen(eq=False)
class Hull:
    """``points`` (n, 3): the corners. ``triangles`` (t, 3): the surface, counter-clockwise seen
    from outside; a flat hull has both sides, a line has none."""

    points: FloatArray
    triangles: IntArray

    def planes(self) -> tuple[FloatArray, FloatArray]:
        """Outward unit normals (f, 3) and offsets (f,): the hull is where ``normals @ x <=
        offsets``. Triangles of one plane share one. Shared and read-only."""
        return _planes_of(self)


@lru_cache(1024)
def _planes_of(hull: Hull) -> tuple[FloatArray, FloatArray]:
    a, b, c = (hull.points[hull.triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    kept = lengths > 0
    normals = normals[kept] / lengths[kept, None]
    offsets = np.einsum("ij,ij->i", normals, a[kept])
    extent = float(np.max(np.ptp(hull.points, axis=0)))
    keys = np.round(np.concatenate([normals, offsets[:, None] / extent], axis=1), 6)
    _, first = np.unique(keys, axis=0, return_index=True)
    first.sort()
    normals = normals[first]
    offsets = offsets[first]
    normals.flags.writeable = offsets.flags.writeable = False
    return normals, offsets


def extreme_points(points: FloatArray, count: int) -> FloatArray:
    """The extreme points in ``count`` directions spread evenly over the sphere. Very many points
    are first reduced to the farthest from the centre in small solid angles."""
    if len(points) > 10 * count:
        points = points[
            _farthest(points - (points.min(axis=0) + points.max(axis=0)) / 2, 4 * count)
        ]
    k = np.arange(count) + 0.5
    z = 1 - 2 * k / count
    angle = np.pi * (1 + 5**0.5) * k
    ring = np.sqrt(1 - z * z)
    directions = np.stack([ring * np.cos(angle), ring * np.sin(angle), z], axis=1)
    index = [
        np.argmax(part @ points.T, axis=1)
        for part in np.array_split(directions, max(1, count // 256))
    ]
    return np.asarray(points[np.unique(np.concatenate(index))])


def _farthest(offsets: FloatArray, count: int) -> IntArray:
    """Numbers of the points farthest from the origin in about ``count`` solid angles, the cells of
    a grid on the faces of a cube."""
    side = max(1, int((count / 6) ** 0.5))
    size = np.abs(offsets)
    axis = size.argmax(axis=1)
    row = np.arange(len(offsets))
    largest = np.maximum(size[row, axis], 1e-300)
    cell = [
        np.minimum((offsets[row, (axis + k) % 3] / largest + 1) / 2 * side, side - 1).astype(
            np.int64
        )
        for k in (1, 2)
    ]
    face = 2 * axis + (offsets[row, axis] < 0)
    key = (face * side + cell[0]) * side + cell[1]
    order = np.lexsort((np.einsum("ni,ni->n", offsets, offsets), key))
    last = np.append(key[order][1:] != key[order][:-1], True)
    return np.asarray(order[last])


def convex_hull(points: FloatArray, tolerance: float = 0.0) -> Hull:
    """The convex hull of ``points`` (n, 3), at least one. Points within 1e-9 of the extent of a
    face count as lying in it. ``tolerance`` [m]: distance up to which points may be outside, which
    leaves out corners of a smooth surface."""
    points = np.unique(np.asarray(points, dtype=np.float64), axis=0)
    if len(points) > MAX_HULL_POINTS and tolerance == 0:
        points = extreme_points(points, MAX_HULL_POINTS)
    return _hull_of(points.tobytes(), tolerance)


@lru_cache(1024)
def _hull_of(coordinates: bytes, tolerance: float) -> Hull:
    """The hull of distinct points, cached for scenes with the same meshes and for shrunk hulls."""
    points = np.frombuffer(coordinates).reshape(-1, 3)
    hull = _computed_hull(points, tolerance)
    hull.points.flags.writeable = hull.triangles.flags.writeable = False
    return hull


def _computed_hull(points: FloatArray, tolerance: float) -> Hull:
    extent = float(np.max(np.ptp(points, axis=0)))
    simplex = _simplex(points, 1e-9 * max(extent, float(np.max(np.abs(points))) * 1e-4))
    if len(simplex) == 1:
        return Hull(points[simplex], np.zeros((0, 3), dtype=np.int64))
    if len(simplex) == 2:
        direction = points[simplex[1]] - points[simplex[0]]
        along = points @ direction
        return Hull(
            points[[int(np.argmin(along)), int(np.argmax(along))]], np.zeros((0, 3), dtype=np.int64)
        )
    if len(simplex) == 3:
        return _flat_hull(points, points[simplex])
    return _Quickhull(points, simplex, 1e-9 * extent, tolerance).hull()


def _simplex(points: FloatArray, tolerance: float) -> list[int]:
    """Indices of up to four points that span the space of all of them."""
    low = int(np.lexsort(points.T)[0])
    offsets = points - points[low]
    distance = np.linalg.norm(offsets, axis=1)
    second = int(distance.argmax())
    if distance[second] <= tolerance:
        return [low]
    axis = offsets[second] / distance[second]
    flat = offsets - np.outer(offsets @ axis, axis)
    distance = np.linalg.norm(flat, axis=1)
    third = int(distance.argmax())
    if distance[third] <= tolerance:
        return [low, second]
    normal = np.cross(axis, flat[third])
    normal /= np.linalg.norm(normal)
    height = np.abs(offsets @ normal)
    fourth = int(height.argmax())
    if height[fourth] <= tolerance:
        return [low, second, third]
    return [low, second, third, fourth]


def _flat_hull(points: FloatArray, triangle: FloatArray) -> Hull:
    """Hull of points in one plane: the polygon, both sides."""
    u = triangle[1] - triangle[0]
    u = u / np.linalg.norm(u)
    normal = np.cross(u, triangle[2] - triangle[0])
    normal /= np.linalg.norm(normal)
    plane = np.stack(
        [(points - triangle[0]) @ u, (points - triangle[0]) @ np.cross(normal, u)], axis=1
    )
    outline = hull_2d(plane)
    fan = np.array([[0, k, k + 1] for k in range(1, len(outline) - 1)], dtype=np.int64)
    return Hull(points[outline], np.concatenate([fan, fan[:, ::-1]]))


def hull_2d(points: FloatArray) -> IntArray:
    """Indices of the corners of the convex hull of ``points`` (n, 2), counter-clockwise (Andrew's
    monotone chain)."""
    order = np.lexsort((points[:, 1], points[:, 0])).tolist()
    xy = points.tolist()

    def chain(indices: list[int]) -> list[int]:
        kept: list[int] = []
        for i in indices:
            while len(kept) > 1:
                (ax, ay), (bx, by), (cx, cy) = xy[kept[-2]], xy[kept[-1]], xy[i]
                if (bx - ax) * (cy - ay) - (by - ay) * (cx - ax) > 0:
                    break
                kept.pop()
            kept.append(i)
        return kept[:-1]

    if len(order) == 1:
        return np.array(order, dtype=np.int64)
    return np.array(chain(order) + chain(order[::-1]), dtype=np.int64)


class _Quickhull:
    """Quickhull (Barber, Dobkin, Huhdanpaa 1996): the farthest point outside a face replaces all
    the faces it sees.

    Args:
        points: (n, 3) [m].
        simplex: numbers of four points that span the space.
        level: height above a face up to which points lie in it [m].
        tolerance: height above a face up to which points need not become corners [m].
    """

    def __init__(
        self, points: FloatArray, simplex: list[int], level: float, tolerance: float
    ) -> None:
        self._points = points
        self._enough = max(level, tolerance)
        self._polytope = Polytope(points.tolist(), level)
        self._outside: dict[int, IntArray] = {}  # of faces: the points assigned to each
        a, b, c, d = simplex
        if (
            np.dot(np.cross(points[b] - points[a], points[c] - points[a]), points[d] - points[a])
            > 0
        ):
            b, c = c, b
        corners = (a, b, c), (a, d, b), (b, d, c), (c, d, a)
        waiting = [self._polytope.add_face(*face) for face in corners]
        self._share_out(np.setdiff1d(np.arange(len(points)), simplex), waiting)
        while waiting:
            face = waiting.pop()
            own = self._outside.pop(face, None)
            if own is None:
                continue
            replaced, created = self._polytope.add_corner(int(own[-1]), face)
            others = [self._outside.pop(each) for each in replaced if each in self._outside]
            self._share_out(np.concatenate([own[:-1], *others]), created)
            waiting += created

    def hull(self) -> Hull:
        corners = [corners for corners, _, _ in self._polytope.faces.values()]
        used, flat = np.unique(np.array(corners, dtype=np.int64), return_inverse=True)
        return Hull(self._points[used], flat.reshape(-1, 3).astype(np.int64))

    def _share_out(self, indices: IntArray, numbers: list[int]) -> None:
        """Assign every point outside some face to the face it is farthest from, the farthest of
        each last."""
        if not len(indices):
            return
        _, normals, offsets = zip(*(self._polytope.faces[face] for face in numbers), strict=True)
        heights = self._points.take(indices, axis=0) @ np.array(normals).T
        heights -= offsets
        top = heights.max(axis=1)
        outside = (top > self._enough).nonzero()[0]
        if not len(outside):
            return
        best = heights.argmax(axis=1)
        order = outside[np.lexsort((top[outside], best[outside]))]
        counts = np.bincount(best[order], minlength=len(numbers)).tolist()
        end = 0
        for face, count in zip(numbers, counts, strict=True):
            if count:
                end += count
                self._outside[face] = indices[order[end - count : end]]


def shrunk_hull(hull: Hull, depth: float) -> Hull | None:
    """The hull with every face moved inwards by ``depth`` metres (outwards where negative); None
    where it vanishes."""
    if depth == 0:
        return hull
    # A flat hull has two faces in opposite directions at the same place.
    if len(hull.triangles) == 0 or len(hull.planes()[0]) <= 3:
        return None
    normals, offsets = hull.planes()
    offsets = offsets - depth
    centre = _deep_point(normals, offsets, hull.points.mean(axis=0))
    slack = offsets - normals @ centre
    extent = float(np.max(np.ptp(hull.points, axis=0)))
    if np.min(slack) <= 1e-6 * extent:
        return None
    # Duality: a plane at distance s from the centre becomes the point normal / s; a face of their
    # hull becomes a corner.
    dual = convex_hull(normals / slack[:, None])
    dual_normals, dual_offsets = dual.planes()
    return convex_hull(centre + dual_normals / dual_offsets[:, None])


def _deep_point(normals: FloatArray, offsets: FloatArray, start: FloatArray) -> FloatArray:
    """A point well inside the half-spaces, by decreasing steps away from the nearest plane."""
    best = point = start
    best_slack = float(np.min(offsets - normals @ start))
    step = float(np.max(np.abs(offsets - normals @ start)))
    for _ in range(200):
        slack = offsets - normals @ point
        nearest = int(np.argmin(slack))
        if slack[nearest] > best_slack:
            best = point
            best_slack = float(slack[nearest])
        point = point - step * normals[nearest]
        step *= 0.95
    return best
