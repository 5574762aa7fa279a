"""Nearest points of boxes and boxes, and of boxes and triangles, by separating axes, many pairs at
a time.

Distances are exact where the nearest features are a face or two crossing edges, and otherwise lower
bounds; ``exact`` says which.
"""

from __future__ import annotations

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...frozen import frozen
from .box_axes import FACE_PREFERENCE, FIRST_EDGE_AXIS, best_axes, edge_points
from .closed_forms import Separation
from .frames import COLUMN, added, cross, dot, pick, relative, turned, turned_back

_ON_FACE = 1e-9
"""Metres beyond the edge of a face within which a point counts as over it."""


@frozen
class AxisSeparation(Separation):
    """A separation and, per pair, whether its distance is ``exact`` (else it is a lower bound)."""

    exact: BoolArray


def box_to_box(
    rotation_a: FloatArray,
    centre_a: FloatArray,
    half_a: FloatArray,
    rotation_b: FloatArray,
    centre_b: FloatArray,
    half_b: FloatArray,
) -> AxisSeparation:
    """Separations of pairs of boxes in world space.

    Args:
        rotation_a: of the first boxes (3, 3, n).
        centre_a: of the first (3, n) [m].
        half_a: half extents of the first (3, n) [m], which may be 0.
        rotation_b: of the second boxes (3, 3, n).
        centre_b: of the second (3, n) [m].
        half_b: half extents of the second (3, n) [m], which may be 0.
    """
    rotation = relative(rotation_a, rotation_b)
    offset = turned_back(rotation_a, centre_b - centre_a)
    distance, axis = best_axes(rotation, offset, half_a, half_b)
    of_a = axis < 3
    of_b = (axis >= 3) & (axis < FIRST_EDGE_AXIS)
    normal = np.where(of_a, axis == COLUMN, pick(rotation.reshape(9, -1), 3 * COLUMN + axis % 3))
    normal *= np.where(dot(normal, offset) < 0, -1.0, 1.0)
    # Face of the first: the second's supporting point must lie over that face; and the other way
    # round.
    first = _support(normal, half_a, offset)
    second = (
        turned(
            rotation,
            _support(-turned_back(rotation, normal), half_b, -turned_back(rotation, offset)),
        )
        + offset
    )
    over_a = second - normal * distance
    over_b = first + normal * distance
    inside_a = (np.abs(over_a) <= half_a + _ON_FACE).all(axis=0)
    inside_b = (np.abs(turned_back(rotation, over_b - offset)) <= half_b + _ON_FACE).all(axis=0)
    first = np.where(of_a, over_a, first)
    second = np.where(of_b, over_b, second)
    exact = (of_a & inside_a) | (of_b & inside_b)
    edges = np.flatnonzero(axis >= FIRST_EDGE_AXIS)
    if len(edges):
        points = edge_points(
            axis[edges], rotation[..., edges], offset[:, edges], half_a[:, edges], half_b[:, edges]
        )
        normal[:, edges] = points.normal
        first[:, edges] = points.first
        second[:, edges] = points.second
        exact[edges] = points.within
    first, second = (turned(rotation_a, end) + centre_a for end in (first, second))
    return AxisSeparation(
        distance, turned(rotation_a, normal), first, second, exact | (distance <= 0)
    )


def _support(direction: FloatArray, half: FloatArray, towards: FloatArray) -> FloatArray:
    """The point of a box farthest along ``direction``; along axes perpendicular to it, the
    coordinate nearest to ``towards``."""
    free = np.clip(towards, -half, half)
    return np.where(np.abs(direction) < 1e-7, free, np.where(direction < 0, -half, half))


def box_to_triangle(
    rotation: FloatArray, centre: FloatArray, half: FloatArray, corners: FloatArray
) -> AxisSeparation:
    """Boxes and triangles (3, 3, n) by coordinate and corner, in world space."""
    local = turned_back(rotation, corners - centre[:, None])
    edges = local[:, [1, 2, 0]] - local
    plane = cross(edges[:, 0], edges[:, 1])
    count = centre.shape[1]
    # Axes: triangle normal, box faces, box axis i x edge j.
    axes = np.empty((3, 13, count))
    axes[:, 0] = plane
    axes[:, 1:4] = np.eye(3)[:, :, None]
    axes[:, 4:] = cross(np.eye(3)[:, :, None, None], edges[:, None]).reshape(3, 9, count)
    length = np.sqrt(dot(axes, axes))
    scale = np.sqrt(dot(edges, edges)).max(axis=0)
    usable = length > 1e-6 * np.concatenate(
        [scale[None] ** 2, np.ones((3, count)), np.repeat(scale[None], 9, axis=0)]
    )
    axes /= np.where(usable, length, 1.0)
    heights = dot(axes[:, :, None], local[:, None])
    extent = dot(np.abs(axes), half[:, None])
    low = heights.min(axis=1)
    high = heights.max(axis=1)
    # From the box to the triangle along +axis and along -axis.
    ahead = low - extent
    behind = -high - extent
    distance = np.where(usable, np.maximum(ahead, behind), -np.inf)
    sign = np.where(ahead >= behind, 1.0, -1.0)
    preferred = distance.copy()
    preferred[4:] -= FACE_PREFERENCE
    best = preferred.argmax(axis=0)
    distance = pick(distance, best)
    normal = axes[:, best, np.arange(count)] * pick(sign, best)
    first = _support(normal, half, added(local) / 3)
    corner_heights = dot(normal[:, None], local)
    lowest = corner_heights <= corner_heights.min(axis=0) + 1e-7
    second = added(local * (lowest / lowest.sum(axis=0)))

    near_box = second - normal * distance
    over_box = (np.abs(near_box) <= half + _ON_FACE).all(axis=0)
    foot = first + normal * distance
    over_triangle = np.ones(count, dtype=np.bool_)
    for k in range(3):
        over_triangle &= dot(cross(edges[:, k], foot - local[:, k]), plane) >= -1e-9 * scale**3
    of_plane = best == 0
    of_box = (best > 0) & (best < 4)
    exact = (of_plane & over_triangle) | (of_box & over_box) | (distance <= 0)
    second = np.where(of_plane, foot, second)
    first = np.where(of_box, near_box, first)
    first, second = (turned(rotation, end) + centre for end in (first, second))
    return AxisSeparation(distance, turned(rotation, normal), first, second, exact)
