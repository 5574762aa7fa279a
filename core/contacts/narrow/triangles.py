"""Distances between triangles, many pairs at a time."""

from __future__ import annotations

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray, chosen_of, joined, taken
from .closed_forms import Separation, merged, segment_to_triangle
from .frames import chunks, cross, dot, following, turned
from .manifold import contact_plane

_FACE_PREFERENCE = 1e-6
"""Metres by which a pair of edges must be further apart than the faces, so that parallel faces have
the faces' normal."""


_AT_ONCE = 512
"""Pairs of triangles whose edges are compared at a time: few enough for the processor's cache."""

_AXES = 11
"""Axes along which the penetration of two faces that face each other may be least: both normals,
and the cross products of their edges."""

_NARROW = 1e-6
"""The share of their extent by which triangles may be apart and still count as overlapping: more
than the rounding of what is computed of both."""


def triangle_to_triangle(first: FloatArray, second: FloatArray) -> Separation:
    """Pairs of triangles (3, 3, n) by coordinate and corner: the nearest of the edges of either and
    the other. Of two that cross, the deepest way of an edge through the other."""
    return joined(
        [_apart(first[..., part], second[..., part]) for part in chunks(first.shape[2], 512)]
    )


def _apart(first: FloatArray, second: FloatArray) -> Separation:
    number = np.arange(first.shape[2])
    start, corners = (
        np.concatenate([first, second], axis=2),
        np.concatenate([second, first], axis=2),
    )
    found = segment_to_triangle(
        start.reshape(3, -1), following(start).reshape(3, -1), np.tile(corners, 3)
    )
    best = found.distance.reshape(6, -1).argmin(axis=0)
    nearest = chosen_of(found, best * len(number) + number)
    flipped = Separation(nearest.distance, -nearest.normal, nearest.second, nearest.first)
    return merged(nearest, flipped, best % 2 == 1)


def crossing_lines(first: FloatArray, second: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The lines along which pairs of triangles (3, 3, n) cross: middles (3, n) and vectors (3, n)
    from end to end, along the cross product of both normals; 0 where they do not cross."""
    along = cross(unit_normals(first), unit_normals(second))
    squared = dot(along, along)
    spans = []
    points = []
    for corners, other in ((first, second), (second, first)):
        normal = unit_normals(other)
        height = dot(normal[:, None], corners - other[:, :1])
        after = height[[1, 2, 0]]
        end = following(corners)
        through = (height >= 0) != (after >= 0)
        share = np.divide(height, height - after, out=np.zeros_like(height), where=through)
        place = corners + (end - corners) * share
        at = dot(along[:, None], place)
        spans.append(
            (
                np.where(through, at, np.inf).min(axis=0),
                np.where(through, at, -np.inf).max(axis=0),
            )
        )
        points.append(place[:, through.argmax(axis=0), np.arange(place.shape[2])])
    begin = np.maximum(spans[0][0], spans[1][0])
    end = np.minimum(spans[0][1], spans[1][1])
    meets = (end > begin) & (squared > 1e-18)
    begin = np.where(meets, begin, 0.0)
    end = np.where(meets, end, 0.0)
    step = along / np.where(meets, squared, 1.0)
    from_point = np.where(meets, (begin + end) / 2 - dot(along, points[0]), 0.0)
    return points[0] + step * from_point, step * (end - begin)


def apart_by(first: FloatArray, second: FloatArray) -> FloatArray:
    """Lower bounds (n,) on the distances of triangles: along their normals and the line of their
    middles."""
    middles = (second.sum(axis=1) - first.sum(axis=1)) / 3
    length = np.sqrt(dot(middles, middles))
    axes = unit_normals(first), unit_normals(second), middles / np.where(length > 0, length, 1.0)
    apart = np.full(first.shape[2], -np.inf)
    for axis in axes:
        apart = np.maximum(apart, np.maximum(*both_ways_apart(first, second, axis)))
    return apart


def both_ways_apart(
    first: FloatArray, second: FloatArray, axis: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """How far apart triangles are along unit vectors (3, n), signed (n,), the second ahead of the
    first, and behind it."""
    a = dot(axis[:, None], first)
    b = dot(axis[:, None], second)
    return b.min(axis=0) - a.max(axis=0), a.min(axis=0) - b.max(axis=0)


def beside(way: FloatArray, reach: FloatArray, normal: FloatArray) -> BoolArray:
    """Which triangles are surely not over others, seen along unit normals (3, n), given the ``way``
    (3, n) between their middles and the sum ``reach`` (n,) of their radii [m]."""
    return dot(way, way) - dot(way, normal) ** 2 > reach**2


def over_each_other(first: FloatArray, second: FloatArray, axis: FloatArray) -> IntArray:
    """The numbers (m,) of the pairs of triangles (3, 3, n) that may overlap as seen along unit
    vectors (3, n): the others are apart along one side of either."""
    plane = np.array(contact_plane(axis))
    a = turned(plane, first)
    b = turned(plane, second)
    size = np.maximum(np.ptp(a, axis=1), np.ptp(b, axis=1)).max(axis=0)
    low = np.maximum(a.min(axis=1), b.min(axis=1))
    high = np.minimum(a.max(axis=1), b.max(axis=1))
    found = np.flatnonzero((low - high).max(axis=0) <= _NARROW * size)
    for corners in (a, b):
        for k in range(3):
            x, y = taken(corners[:, (k + 1) % 3] - corners[:, k], found)
            across = np.array([-y, x])
            own, other = (dot(across[:, None], taken(side, found)) for side in (a, b))
            apart = np.maximum(
                own.min(axis=0) - other.max(axis=0), other.min(axis=0) - own.max(axis=0)
            )
            found = found[apart <= _NARROW * size[found] * np.hypot(x, y)]
    return found


def unit_normals(corners: FloatArray) -> FloatArray:
    """Unit normals (3, n) of triangles (3, 3, n); 0 of one without area."""
    return normals_and_areas(corners)[0]


def normals_and_areas(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit normals (3, n) of triangles (3, 3, n), 0 of one without area, and areas (n,) [m^2]."""
    normal = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.sqrt(dot(normal, normal))
    return normal / np.where(length > 0, length, 1.0), length / 2


def facing_axes(
    first: FloatArray, second: FloatArray, normal_a: FloatArray, normal_b: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Signed separations (n,) of faces of two solids that face each other, their outward normals
    being ``normal_a`` and ``normal_b`` (3, n), and the axes (3, n) from the first to the second.
    Negative where they have passed through each other: of the axes between the two normals, that
    along which they are least deep (separating axes)."""
    pairs = first, second, normal_a, normal_b
    best, axis = _facing_axis(*pairs, 0)
    for number in range(1, _AXES):
        other, along = _facing_axis(*pairs, number)
        axis = np.where(other > best, along, axis)
        best = np.maximum(best, other)
    return _separation(first, second, axis), axis


def _facing_axis(
    first: FloatArray, second: FloatArray, normal_a: FloatArray, normal_b: FloatArray, number: int
) -> tuple[FloatArray, FloatArray]:
    """Separations (n,) of faces along one of the axes of `facing_axes`, and that axis (3, n).

    An axis across two edges counts only where it lies between the normals; elsewhere the separation
    is -infinity.

    Args:
        first: corners of the first triangles (3, 3, n) [m].
        second: corners of the second (3, 3, n) [m].
        normal_a: outward unit normals of the first (3, n).
        normal_b: outward unit normals of the second (3, n).
        number: of the axis: 0 and 1 are the normals, then come the cross products of the edges.
    """
    if number < 2:
        axis = (normal_a, -normal_b)[number]
        return _separation(first, second, axis), axis
    of_a, of_b = divmod(number - 2, 3)
    axis = cross(
        first[:, (of_a + 1) % 3] - first[:, of_a], second[:, (of_b + 1) % 3] - second[:, of_b]
    )
    length = np.sqrt(dot(axis, axis))
    axis = axis / np.where(length > 0, length, 1.0)
    axis = axis * np.where(dot(axis, normal_a - normal_b) < 0, -1.0, 1.0)
    within = (length > 0) & (dot(axis, normal_a) > 0) & (dot(axis, normal_b) < 0)
    return np.where(within, _separation(first, second, axis) - _FACE_PREFERENCE, -np.inf), axis


def _separation(first: FloatArray, second: FloatArray, axis: FloatArray) -> FloatArray:
    """How far apart triangles are along unit vectors (3, n): signed (n,)."""
    return np.asarray(
        dot(axis[:, None], second).min(axis=0) - dot(axis[:, None], first).max(axis=0)
    )
