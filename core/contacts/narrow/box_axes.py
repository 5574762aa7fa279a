"""The separating-axis test of two boxes, many pairs at a time (Gottschalk, Lin and Manocha 1996).

Of two boxes that overlap, the least depth over the normals of their faces and the cross products of their edges is the exact depth. Of two
that are apart, the greatest separation over those axes is their distance where the features facing each other are a face or two crossing
edges, and otherwise a lower bound.

Arrays have the pairs along their last axis. The second box is placed by a rotation (3, 3, p) and a centre (3, p) in the frame of the first;
half extents are (3, p).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray
from .frames import COLUMN, pick

FACE_PREFERENCE = 1e-6
"""Metres by which an axis of two edges must be better than that of a face to be chosen."""

EDGE_TOLERANCE = 1e-9
"""Part of a face's or an edge's size within which a point on its end counts as on it."""

_PARALLEL = 1e-8
"""Squared sine of the angle between two edges below which they give no axis."""

FIRST_EDGE_AXIS = 6
"""Number of the first axis that belongs to two edges."""

NEXT = np.array([1, 2, 0])
AFTER = np.array([2, 0, 1])


@dataclass(frozen=True, slots=True)
class BestAxes:
    """Axes of greatest separation: ``distance`` (p,) along them; ``axis`` (p,) 0-2 a face of the first box, 3-5 a face of the second, from
    ``FIRST_EDGE_AXIS`` on edges i and j as ``6 + 3 i + j``."""

    distance: FloatArray
    axis: IntArray


def best_axes(rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray) -> BestAxes:
    """The axis of greatest separation of each pair."""
    size = np.abs(rotation)
    offset_b = np.einsum("ijp,ip->jp", rotation, offset)
    separation = np.empty((15, offset.shape[1]))
    np.subtract(np.abs(offset), half_a + np.einsum("ijp,jp->ip", size, half_b), out=separation[:3])
    np.subtract(np.abs(offset_b), half_b + np.einsum("ijp,ip->jp", size, half_a), out=separation[3:6])
    # Axis i of the first x axis j of the second: e_i x r_j, with r_j column j of the rotation.
    turned_1, turned_2 = rotation[NEXT], rotation[AFTER]
    along = offset[AFTER, None] * turned_1
    along -= offset[NEXT, None] * turned_2
    extent = half_a[NEXT, None] * size[AFTER]
    extent += half_a[AFTER, None] * size[NEXT]
    extent += half_b[NEXT] * size[:, AFTER] + half_b[AFTER] * size[:, NEXT]
    # The length of the axis from its components: 1 - size^2 is not that of float32 rotations, nor 0 for parallel edges.
    squared = np.multiply(turned_1, turned_1, out=turned_1)
    squared += np.multiply(turned_2, turned_2, out=turned_2)
    edges = separation[FIRST_EDGE_AXIS:].reshape(3, 3, -1)
    np.subtract(np.abs(along, out=along), extent, out=edges)
    edges /= np.sqrt(np.maximum(squared, _PARALLEL))
    edges -= FACE_PREFERENCE
    np.copyto(edges, -np.inf, where=squared < _PARALLEL)
    axis = separation.argmax(axis=0)
    distance = pick(separation, axis)
    distance += np.where(axis < FIRST_EDGE_AXIS, 0.0, FACE_PREFERENCE)
    return BestAxes(distance, axis)


@dataclass(frozen=True, slots=True)
class EdgePoints:
    """Unit ``normal`` (3, p) from first to second, the points of two edges that are nearest to each other on the first box (3, p) and on
    the second, and whether the nearest points of their lines lie ``within`` (p,) both edges."""

    normal: FloatArray
    first: FloatArray
    second: FloatArray
    within: BoolArray


def edge_points(axis: IntArray, rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray) -> EdgePoints:
    """The nearest points of the two edges that belong to each ``axis`` (p,) of two edges."""
    i, j = (axis - FIRST_EDGE_AXIS) // 3, (axis - FIRST_EDGE_AXIS) % 3
    way = pick(rotation.reshape(9, -1), 3 * COLUMN + j)  # (3, p): direction of the second's edge
    of_i = i == COLUMN
    normal = np.where(NEXT[i] == COLUMN, -pick(way, AFTER[i]), np.where(of_i, 0.0, pick(way, NEXT[i])))
    length = np.sqrt(np.einsum("ip,ip->p", normal, normal))
    normal /= np.where(np.einsum("ip,ip->p", normal, offset) < 0, -length, length)
    on_a = np.where(of_i, 0.0, np.where(normal < 0, -half_a, half_a))
    on_b = np.where(j == COLUMN, 0.0, np.where(np.einsum("ijp,ip->jp", rotation, normal) < 0, half_b, -half_b))
    on_b = np.einsum("ijp,jp->ip", rotation, on_b) + offset
    between = on_b - on_a
    along_i, along_j, slant = pick(between, i), np.einsum("ip,ip->p", between, way), pick(way, i)
    area = 1.0 - slant * slant
    s, t = (along_i - slant * along_j) / area, (slant * along_i - along_j) / area
    most_s, most_t = pick(half_a, i), pick(half_b, j)
    within = (np.abs(s) <= most_s * (1 + EDGE_TOLERANCE)) & (np.abs(t) <= most_t * (1 + EDGE_TOLERANCE))
    on_a = np.where(of_i, np.clip(s, -most_s, most_s), on_a)
    on_b += way * np.clip(t, -most_t, most_t)
    return EdgePoints(normal, on_a, on_b, within)


def axis_normals(axis: IntArray, rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray) -> FloatArray:
    """Unit normals (3, p) from first to second along each ``axis`` (p,)."""
    k = axis % 3
    normal = np.where(axis < 3, k == COLUMN, pick(rotation.reshape(9, -1), 3 * COLUMN + k))
    normal *= np.where(np.einsum("ip,ip->p", normal, offset) < 0, -1.0, 1.0)
    edges = np.flatnonzero(axis >= FIRST_EDGE_AXIS)
    if len(edges):
        boxes = rotation[..., edges], offset[:, edges], half_a[:, edges], half_b[:, edges]
        normal[:, edges] = edge_points(axis[edges], *boxes).normal
    return normal
