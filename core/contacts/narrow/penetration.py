"""Penetration depth of two convex bodies by the expanding polytope algorithm (EPA; van den Bergen
2001).

The depth is the distance of the origin from the boundary of the bodies' Minkowski difference. A
polytope inside that difference is grown where it is nearest to the origin: the nearest face bounds
the depth from below, the supporting plane in the direction of its normal bounds it from above. The
algorithm ends when both agree, so the result is the global minimum and known to ``_TOLERANCE``.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable

import numpy as np

from ...arrays import FloatArray
from ...frozen import frozen
from ..polytope import Point, Polytope
from .frames import SIDES

_TOLERANCE = 1e-9
"""Metres between the bounds at which the depth counts as found."""

_FLAT = 1e-9
"""Metres of thickness below which a Minkowski difference counts as flat."""

_MOST_STEPS = 1000
_IDLE_STEPS = 200
"""Steps, and steps without a better direction, after which the best direction so far is used: where
the difference has rotational symmetry, many directions are equally good, and the bounds never
agree."""

_TILT = 1e-4
"""Angle [rad] between a face's normal and the directions in which its other corners are sought:
faces that differ by less count as one, since coordinates of single precision put hardly any corners
on one plane."""

_MOST_CORNERS = 30

_NEXT = np.array([1, 2, 0])
_AFTER_NEXT = np.array([2, 0, 1])

Farthest = Callable[[FloatArray], FloatArray]
"""The points (..., 3) of a convex body that are farthest along unit directions (..., 3)."""


@frozen
class Penetration:
    """``depth`` [m] by which two bodies overlap along the unit ``normal`` from first to second,
    ``middle`` between the two deepest points."""

    depth: float
    normal: FloatArray
    middle: FloatArray


def row_dots(a: FloatArray, b: FloatArray) -> FloatArray:
    """Dot products (m,) of vectors (m, 3) or (3,)."""
    return np.asarray(np.einsum("...i,...i->...", a, b))


def row_cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross products (m, 3) of vectors (m, 3) or (3,), with the bits of `np.cross` and a fifth of
    its overhead."""
    return a.take(_NEXT, -1) * b.take(_AFTER_NEXT, -1) - a.take(_AFTER_NEXT, -1) * b.take(_NEXT, -1)


def _length(vector: FloatArray) -> float:
    return math.sqrt(vector @ vector)


def penetration(first: Farthest, second: Farthest) -> Penetration:
    """Penetration of two overlapping convex bodies given by their farthest points. Where both are
    flat and lie in one plane the depth is 0 along its normal."""

    def supports(ways: FloatArray) -> tuple[FloatArray, FloatArray]:
        of_first = first(ways)
        return of_first - second(-ways), of_first

    simplex = _simplex(supports)
    if isinstance(simplex, Penetration):
        return simplex
    return _expanded(simplex, supports)


_Supports = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""Points (..., 3) of the Minkowski difference farthest along directions (..., 3), and the points of
the first body that they come from."""


def _simplex(supports: _Supports) -> _Expanding | Penetration:
    """A tetrahedron of boundary points, or the penetration of a flat difference."""
    points, sources = supports(SIDES)
    a = points[0]
    source_a = sources[0]
    k = int(row_dots(points - a, points - a).argmax())
    b = points[k]
    source_b = sources[k]
    way = b - a
    axis = way / max(_length(way), 1e-300)
    u = row_cross(axis, SIDES[0 if abs(axis[0]) < 0.7 else 1])
    u /= _length(u)
    v = row_cross(axis, u)
    points, sources = supports(np.array([u, -u, v, -v]))
    across = points - a
    across -= (across @ axis)[:, None] * axis
    k = int(row_dots(across, across).argmax())
    c = points[k]
    source_c = sources[k]
    normal = row_cross(way, c - a)
    length = _length(normal)
    normal = normal / length if length > 0 else u
    points, sources = supports(np.array([normal, -normal]))
    height = (points - a) @ normal
    k = int(np.abs(height).argmax())
    if abs(height[k]) <= _FLAT:
        depth = float(min(points[0] @ normal, -(points[1] @ normal)))
        return Penetration(depth, normal, (source_a + source_b + source_c) / 3)
    polytope = _Expanding(
        [tuple(p.tolist()) for p in (a, b, c, points[k])],
        [source_a, source_b, source_c, sources[k]],
    )
    up = height[k] > 0
    for corners in ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)):
        polytope.add_face(*(corners[::-1] if up else corners))
    return polytope


def _expanded(polytope: _Expanding, supports: _Supports) -> Penetration:
    """Expand the polytope until its nearest face lies on the boundary."""
    least, nearest, found = math.inf, None, 0
    for step in range(_MOST_STEPS):
        number = polytope.nearest()
        face = _, (nx, ny, nz), offset = polytope.faces[number]
        place, source = supports(np.array((nx, ny, nz)))
        x, y, z = point = tuple(place.tolist())
        height = nx * x + ny * y + nz * z
        final = height - offset <= _TOLERANCE
        if height < least or final:
            least, nearest, found = height, face, step
        if final or step - found == _IDLE_STEPS:
            break
        polytope.add_point(point, source, number)
    assert nearest is not None
    corners, way, _ = nearest
    normal = np.array(way)
    return Penetration(
        least,
        normal,
        _deepest(*polytope.triangle(corners), normal, supports) - normal * (least / 2),
    )


def _deepest(
    points: FloatArray, sources: FloatArray, normal: FloatArray, supports: _Supports
) -> FloatArray:
    """The point of the first body that belongs to the foot of the origin on a face of the
    difference, of which the triangle ``points`` (3, 3) with its ``sources`` (3, 3) is known. Where
    the foot lies beyond an edge of the triangle, the next triangle is found by the corner of the
    face that is farthest out beyond that edge."""
    foot = normal * float(normal @ points[0])
    for _ in range(_MOST_CORNERS):
        edges = row_cross(normal, points[_NEXT] - points)  # inwards
        size = np.sqrt(row_dots(edges, edges))
        inside = row_dots(edges, foot - points)
        k = int((inside / np.where(size > 0, size, 1.0)).argmin())
        if inside[k] >= 0 or size[k] == 0:
            break
        outwards = -edges[k] / size[k]
        corner, source = supports(normal + _TILT * outwards)
        if float((corner - points[k]) @ outwards) <= _FLAT:
            break
        points = np.stack([points[(k + 1) % 3], points[k], corner])
        sources = np.stack([sources[(k + 1) % 3], sources[k], source])
    ahead = points[_NEXT]
    before = points[_AFTER_NEXT]
    areas = row_dots(row_cross(before - ahead, foot - ahead), normal).clip(0.0)
    return np.asarray(areas / areas.sum() @ sources if areas.sum() > 0 else sources.mean(axis=0))


class _Expanding(Polytope):
    """A polytope that grows where it is nearest to the origin. ``sources``: a point of the first
    body per corner."""

    def __init__(self, points: list[Point], sources: list[FloatArray]) -> None:
        super().__init__(points, 1e-3 * _TOLERANCE)
        self._sources = sources
        self._by_offset: list[tuple[float, int]] = []

    def add_face(self, i: int, j: int, k: int) -> int:
        number = super().add_face(i, j, k)
        heapq.heappush(self._by_offset, (self.faces[number][2], number))
        return number

    def nearest(self) -> int:
        """Number of the face nearest the origin."""
        while self._by_offset[0][1] not in self.faces:
            heapq.heappop(self._by_offset)
        return self._by_offset[0][1]

    def add_point(self, point: Point, source: FloatArray, start: int) -> None:
        """Add a corner that sees the face ``start``."""
        self.points.append(point)
        self._sources.append(source)
        self.add_corner(len(self.points) - 1, start)

    def triangle(self, corners: tuple[int, int, int]) -> tuple[FloatArray, FloatArray]:
        """Corners (3, 3) of a face and the points (3, 3) of the first body that they come from."""
        return np.array([self.points[k] for k in corners]), np.array(
            [self._sources[k] for k in corners]
        )
