"""Depths of triangles in convex hulls by separating axes, many at a time.

The depth is the distance of the origin from the boundary of the bodies' Minkowski difference, whose
faces have three kinds of normals: those of the hull's faces, those of the triangle, and those
square to an edge of either that lie between the normals of the faces beside the hull's edge
(Gottschalk et al. 1996).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray, taken
from ...frozen import frozen
from ..hull import Hull
from .closed_forms import Separation
from .frames import cross, dot, following, pick

_SAME = 1e-9
"""Metres between a depth and the overlap along its normal up to which it is confirmed."""

_TILT = 1e-4
"""Slope up to which corners count as equally deep, as of `penetration`: coordinates of single
precision put hardly any of them on one plane."""


@frozen
class _Faces:
    """Outward unit ``normals`` (3, f) and ``offsets`` (f,) [m] of the triangles of a hull, and the
    faces (2, e) to both sides of each of its ``edges``."""

    normals: FloatArray
    offsets: FloatArray
    edges: IntArray


@lru_cache(1024)
def _faces_of(hull: Hull) -> _Faces | None:
    """The faces of a hull, None where it is flat or one of them has no normal."""
    if len(hull.triangles) < 4:
        return None
    corners = hull.points[hull.triangles].transpose(2, 1, 0)
    normals = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.sqrt(dot(normals, normals))
    if not lengths.all():
        return None
    normals /= lengths
    begin = hull.triangles.reshape(-1)
    end = np.roll(hull.triangles, -1, axis=1).reshape(-1)
    way = begin * len(hull.points) + end
    order = way.argsort()
    back = order[np.searchsorted(way[order], end * len(hull.points) + begin)]
    once = begin < end
    edges = np.stack([once.nonzero()[0], back[once]]) // 3
    return _Faces(normals, dot(normals[:, None], corners).max(axis=0), edges)


@dataclass(slots=True)
class _Least:
    """The least overlaps found so far of a hull and n triangles.

    Attributes:
        depth: (n,) [m].
        normal: (3, n) from the hull to the triangle.
        second: (3, n) the deepest point of the triangle.
    """

    depth: FloatArray
    normal: FloatArray
    second: FloatArray


def depths_in_hull(hull: Hull, corners: FloatArray) -> tuple[Separation, BoolArray]:
    """Separations of a hull and triangles that overlap it, and which of them (n,) are sure; the
    others may be wrong. ``corners`` (3, 3, n) by coordinate and corner, in the hull's frame."""
    count = corners.shape[2]
    faces = _faces_of(hull)
    if faces is None:
        none = np.zeros((3, count))
        return Separation(np.zeros(count), none, none, none), np.zeros(count, dtype=np.bool_)
    edges = following(corners) - corners
    overlap = faces.offsets[:, None] - _heights(faces.normals, corners).min(axis=1)
    best = overlap.argmin(axis=0)
    normal = taken(faces.normals, best)
    least = _Least(pick(overlap, best), normal, _lowest(corners, normal))
    _take_own_normals(least, hull, corners, edges)
    _take_edges(least, faces, corners, edges)
    heights = _heights(hull.points.T, least.normal)
    top = heights.max(axis=0)
    on_hull = (heights >= top - _TILT * np.ptp(hull.points, axis=0).sum()).sum(axis=0)
    heights = dot(least.normal[:, None], corners)
    low = heights.min(axis=0)
    extent = np.sqrt(dot(edges, edges)).sum(axis=0)
    on_triangle = (heights <= low + _TILT * extent).sum(axis=0)
    # A face and a corner, or two edges: elsewhere, many points are as deep.
    alone = (on_hull == 1) | (on_triangle == 1) | ((on_hull == 2) & (on_triangle == 2))
    sure = alone & (np.abs(top - low - least.depth) <= _SAME)
    first = least.second + least.normal * least.depth
    return Separation(-least.depth, least.normal, first, least.second), sure


def _take_own_normals(least: _Least, hull: Hull, corners: FloatArray, edges: FloatArray) -> None:
    """Take overlaps along the normals of the triangles, on both sides, where they are less."""
    normal = cross(edges[:, 0], edges[:, 1])
    length = np.sqrt(dot(normal, normal))
    normal /= np.where(length > 0, length, 1.0)
    for side in (normal, -normal):
        heights = _heights(hull.points.T, side)
        overlap = heights.max(axis=0) - dot(side, corners[:, 0])
        of = ((length > 0) & (overlap < least.depth)).nonzero()[0]
        far = hull.points[heights[:, of].argmax(axis=0)].T
        least.depth[of], least.normal[:, of] = overlap[of], side[:, of]
        least.second[:, of] = far - side[:, of] * overlap[of]


def _take_edges(least: _Least, faces: _Faces, corners: FloatArray, edges: FloatArray) -> None:
    """Take overlaps square to an edge of the hull and one of the triangles' ``edges`` (3, 3, n),
    where they are less."""
    rise = _heights(faces.normals, edges)
    rising = rise > 0
    one, other = faces.edges
    edge, side, triangle = (rising[one] != rising[other]).nonzero()
    one = one[edge]
    other = other[edge]
    rise_one = rise[one, side, triangle]
    rise_other = rise[other, side, triangle]
    # Between both faces' normals.
    part_one = np.abs(rise_other)
    part_other = np.abs(rise_one)
    way = taken(faces.normals, one) * part_one + taken(faces.normals, other) * part_other
    length = np.sqrt(dot(way, way))
    normal = way / np.where(length > 0, length, 1.0)
    reach = faces.offsets[one] * part_one + faces.offsets[other] * part_other
    overlap = reach / np.where(length > 0, length, 1.0)
    overlap -= dot(normal[:, None], taken(corners, triangle)).min(axis=0)
    less = ((length > 0) & (overlap < least.depth[triangle])).nonzero()[0]
    less = less[np.lexsort((overlap[less], triangle[less]))]
    of, first = np.unique(triangle[less], return_index=True)
    best = less[first]
    normal = taken(normal, best)
    along = edges[:, side[best], of]
    corner = _lowest(taken(corners, of), normal)
    # Where on the edge a point is as far beneath both faces as the depth says.
    between = taken(faces.normals, one[best]) - taken(faces.normals, other[best])
    room = faces.offsets[one[best]] - faces.offsets[other[best]] - dot(between, corner)
    share = (room - overlap[best] * dot(normal, between)) / (rise_one - rise_other)[best]
    least.depth[of] = overlap[best]
    least.normal[:, of] = normal
    least.second[:, of] = corner + along * share


def _lowest(corners: FloatArray, normal: FloatArray) -> FloatArray:
    """The corners (3, n) that are lowest along normals (3, n)."""
    place = dot(normal[:, None], corners).argmin(axis=0)
    return np.asarray(corners[:, place, np.arange(len(place))])


def _heights(points: FloatArray, direction: FloatArray) -> FloatArray:
    """Heights (k, ...) of points (3, k) along directions (3, ...)."""
    x, y, z = points.reshape(3, -1, *(1,) * (direction.ndim - 1))
    return np.asarray(x * direction[0] + y * direction[1] + z * direction[2])
