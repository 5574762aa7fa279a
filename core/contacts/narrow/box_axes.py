"""The separating-axis test of two boxes, many pairs at a time (Gottschalk, Lin and Manocha 1996).

Of two boxes that overlap, the least depth over the normals of their faces and the cross products of
their edges is the exact depth. Of two that are apart, the greatest separation over those axes is
their distance where the features facing each other are a face or two crossing edges, and otherwise
a lower bound.

Arrays have the pairs along their last axis. The second box is placed by a rotation (3, 3, p) and a
centre (3, p) in the frame of the first; half extents are (3, p).
"""

from __future__ import annotations

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray
from ...frozen import frozen
from .frames import COLUMN, dot, pick, turned, turned_back

FACE_PREFERENCE = 1e-6
"""Metres by which the separation along an axis of two edges must exceed that along the normal of a
face for the axis to be chosen."""

EDGE_TOLERANCE = 1e-9
"""Relative tolerance with which a point at the border of a face or at the end of an edge counts as
lying on it."""

_PARALLEL = 1e-8
"""Squared sine of the angle between two edges below which they count as parallel, so that their
cross product is no axis."""

FIRST_EDGE_AXIS = 6
"""Number of the first axis that belongs to two edges."""

TURN = np.array([0, 1, 2, 0, 1, 2])
_TURNS = (3 * TURN[:5, None] + TURN[:5]).reshape(-1)


def _arrangement(i: int, j: int) -> list[int]:
    """Rows of rotation, offset and half extents of two boxes arranged for edges ``i`` and ``j``,
    whose axes come first, the others in turn: columns of the rotation, offset, half extents of the
    first and of the second."""
    of_a = TURN[i : i + 3].tolist()
    of_b = TURN[j : j + 3].tolist()
    return (
        [3 * m + n for n in of_b for m in of_a]
        + [first + m for first in (9, 12) for m in of_a]
        + [15 + n for n in of_b]
    )


_ARRANGED = np.array([_arrangement(i, j) for i in range(3) for j in range(3)]).T.copy()
_BACK = np.array([[(c - i) % 3 for i in range(3) for _ in range(3)] for c in range(3)])
"""For each pair of edges, the place of each coordinate in the order that begins with ``i``."""


def best_axes(
    rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Greatest separation (p,) of each pair, and the axis (p,) along which it is: 0-2 a face of the
    first box, 3-5 a face of the second, from ``FIRST_EDGE_AXIS`` on edges i and j as ``6 + 3 i +
    j``."""
    count = offset.shape[1]
    size = np.abs(rotation)
    separation = np.empty((15, count))
    of_a = separation[:3]
    of_b = separation[3:FIRST_EDGE_AXIS]
    edges = separation[FIRST_EDGE_AXIS:].reshape(3, 3, -1)
    np.abs(offset, out=of_a)
    of_a -= half_a
    of_a -= turned(size, half_b)
    np.abs(turned_back(rotation, offset), out=of_b)
    of_b -= half_b
    of_b -= turned_back(size, half_a)
    # Axis i of the first x axis j of the second: e_i x r_j, with r_j column j of the rotation. Rows
    # repeated in turn, to be sliced.
    ways = rotation.take(TURN[:5], axis=0)
    sizes = size.reshape(9, -1).take(_TURNS, axis=0).reshape(5, 5, -1)
    turned_1 = ways[1:4]
    turned_2 = ways[2:]
    offset, half_a, half_b = (vector.take(TURN[:5], axis=0) for vector in (offset, half_a, half_b))
    along = offset[2:, None] * turned_1
    along -= offset[1:4, None] * turned_2
    extent = half_a[1:4, None] * sizes[2:, :3]
    extent += half_a[2:, None] * sizes[1:4, :3]
    extent += half_b[1:4] * sizes[:3, 2:]
    extent += half_b[2:] * sizes[:3, 1:4]
    # The length of the axis from its components: 1 - size^2 is not that of float32 rotations, nor 0
    # for parallel edges.
    ways *= ways
    squared = turned_1 + turned_2
    np.subtract(np.abs(along, out=along), extent, out=edges)
    edges /= np.sqrt(np.maximum(squared, _PARALLEL))
    edges -= FACE_PREFERENCE
    np.copyto(edges, -np.inf, where=squared < _PARALLEL)
    axis = separation.argmax(axis=0)
    distance = pick(separation, axis)
    distance += FACE_PREFERENCE * (axis >= FIRST_EDGE_AXIS)
    return distance, axis


@frozen
class EdgePoints:
    """Unit ``normal`` (3, p) from first to second, the points of two edges that are nearest to each
    other on the first box (3, p) and on the second, and whether the nearest points of their lines
    lie ``within`` (p,) both edges."""

    normal: FloatArray
    first: FloatArray
    second: FloatArray
    within: BoolArray


def edge_points(
    axis: IntArray, rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray
) -> EdgePoints:
    """The nearest points of the two edges that belong to each ``axis`` (p,) of two edges.

    Args:
        axis: numbers as of `best_axes`, from `FIRST_EDGE_AXIS` on (p,).
        rotation: of the second box in the frame of the first (3, 3, p).
        offset: its centre there (3, p) [m].
        half_a: half extents of the first (3, p) [m].
        half_b: half extents of the second (3, p) [m].
    """
    pair = axis - FIRST_EDGE_AXIS
    count = len(axis)
    number = np.arange(count)
    rows = np.concatenate([rotation.reshape(9, -1), offset, half_a, half_b]).reshape(-1)
    arranged = rows.take(_ARRANGED.take(pair, axis=1) * count + number)
    ways = arranged[:9].reshape(3, 3, -1)
    offset = arranged[9:12]
    half_a = arranged[12:15]
    half_b = arranged[15:]
    way = ways[0]
    found = np.zeros((3, 3, count))
    normal, on_a, on_b = found
    np.negative(way[2], out=normal[1])
    normal[2] = way[1]
    length = np.sqrt(way[1] * way[1] + way[2] * way[2])
    normal /= np.where(normal[1] * offset[1] + normal[2] * offset[2] < 0, -length, length)
    np.copyto(on_a[1:], np.where(normal[1:] < 0, -half_a[1:], half_a[1:]))
    corner = np.where(
        ways[1:, 1] * normal[1] + ways[1:, 2] * normal[2] < 0, half_b[1:], -half_b[1:]
    )
    np.add(ways[1] * corner[0] + ways[2] * corner[1], offset, out=on_b)
    between = on_b - on_a
    along_i = between[0]
    along_j = dot(between, way)
    slant = way[0]
    area = 1.0 - slant * slant
    s = (along_i - slant * along_j) / area
    t = (slant * along_i - along_j) / area
    within = (np.abs(s) <= half_a[0] * (1 + EDGE_TOLERANCE)) & (
        np.abs(t) <= half_b[0] * (1 + EDGE_TOLERANCE)
    )
    on_a[0] = np.minimum(np.maximum(s, -half_a[0]), half_a[0])
    on_b += way * np.minimum(np.maximum(t, -half_b[0]), half_b[0])
    normal, first, second = found.reshape(3, -1).take(
        _BACK.take(pair, axis=1) * count + number, axis=1
    )
    return EdgePoints(normal, first, second, within)


def axis_normals(
    axis: IntArray, rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray
) -> FloatArray:
    """Unit normals (3, p) from first to second along each ``axis`` (p,).

    Args:
        axis: numbers as of `best_axes` (p,).
        rotation: of the second box in the frame of the first (3, 3, p).
        offset: its centre there (3, p) [m].
        half_a: half extents of the first (3, p) [m].
        half_b: half extents of the second (3, p) [m].
    """
    k = axis % 3
    normal = np.where(axis < 3, k == COLUMN, pick(rotation.reshape(9, -1), 3 * COLUMN + k))
    normal *= np.where(dot(normal, offset) < 0, -1.0, 1.0)
    edges = np.flatnonzero(axis >= FIRST_EDGE_AXIS)
    if len(edges):
        boxes = rotation[..., edges], offset[:, edges], half_a[:, edges], half_b[:, edges]
        normal[:, edges] = edge_points(axis[edges], *boxes).normal
    return normal
