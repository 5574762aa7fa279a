"""Nearest points of boxes and boxes, and of boxes and triangles, by separating axes, many pairs at a time.

Distances are exact where the nearest features are a face or two crossing edges, and otherwise lower bounds; ``exact`` says which.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import BoolArray, FloatArray
from .box_axes import COLUMN, FACE_PREFERENCE, FIRST_EDGE_AXIS, best_axes, edge_points, pick
from .closed_forms import Separation
from .frames import dot, turned, turned_back


@dataclass(frozen=True, slots=True)
class AxisSeparation:
    """A ``separation`` and, per pair, whether its distance is ``exact`` (else it is a lower bound)."""

    separation: Separation
    exact: BoolArray


def box_to_box(
    rotation_a: FloatArray, centre_a: FloatArray, half_a: FloatArray, rotation_b: FloatArray, centre_b: FloatArray, half_b: FloatArray
) -> AxisSeparation:
    """Boxes (n pairs) in world space: rotations (n, 3, 3), centres (n, 3), half extents (n, 3), which may be 0."""
    relative = np.einsum("nji,njk->ikn", rotation_a, rotation_b)
    offset = turned_back(rotation_a, centre_b - centre_a).T
    distance, normal, first, second, exact = _nearest_points(relative, offset, half_a.T, half_b.T)
    ends = (turned(rotation_a, end.T) + centre_a for end in (first, second))
    return AxisSeparation(Separation(distance, turned(rotation_a, normal.T), *ends), exact)


def _nearest_points(
    rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, BoolArray]:
    """Distances (p,), normals, nearest points of the first and of the second box, each (3, p) in the frame of the first, and which
    distances are exact (p,). Pairs last, as in `box_axes`."""
    best = best_axes(rotation, offset, half_a, half_b)
    distance, axis = best.distance, best.axis
    of_a, of_b = axis < 3, (axis >= 3) & (axis < FIRST_EDGE_AXIS)
    normal = np.where(of_a, axis == COLUMN, pick(rotation.reshape(9, -1), 3 * COLUMN + axis % 3))
    normal *= np.where(np.einsum("ip,ip->p", normal, offset) < 0, -1.0, 1.0)
    offset_b = np.einsum("ijp,ip->jp", rotation, offset)
    # Face of the first: the second's supporting point must lie over that face; and the other way round.
    first = _support(normal, half_a, offset)
    second = np.einsum("ijp,jp->ip", rotation, _support(-np.einsum("ijp,ip->jp", rotation, normal), half_b, -offset_b)) + offset
    over_a, over_b = second - normal * distance, first + normal * distance
    inside_a = (np.abs(over_a) <= half_a + 1e-9).all(axis=0)
    inside_b = (np.abs(np.einsum("ijp,ip->jp", rotation, over_b - offset)) <= half_b + 1e-9).all(axis=0)
    first, second = np.where(of_a, over_a, first), np.where(of_b, over_b, second)
    exact = (of_a & inside_a) | (of_b & inside_b)
    edges = np.flatnonzero(axis >= FIRST_EDGE_AXIS)
    if len(edges):
        points = edge_points(axis[edges], rotation[..., edges], offset[:, edges], half_a[:, edges], half_b[:, edges])
        normal[:, edges], first[:, edges], second[:, edges] = points.normal, points.first, points.second
        exact[edges] = points.within
    return distance, normal, first, second, exact | (distance <= 0)


def _support(direction: FloatArray, half: FloatArray, towards: FloatArray) -> FloatArray:
    """The point of a box farthest along ``direction``; along axes perpendicular to it, the coordinate nearest to ``towards``."""
    free = np.clip(towards, -half, half)
    return np.where(np.abs(direction) < 1e-7, free, np.where(direction < 0, -half, half))


def box_to_triangle(rotation: FloatArray, centre: FloatArray, half: FloatArray, corners: FloatArray) -> AxisSeparation:
    """Boxes and triangles (n, 3, 3), corners in world space."""
    local = np.einsum("nji,nkj->nki", rotation, corners - centre[:, None, :])
    edges = local[:, [1, 2, 0]] - local
    plane = np.cross(edges[:, 0], edges[:, 1])
    # Axes: triangle normal, box faces, box axis i x edge j.
    axes = np.empty((len(local), 13, 3))
    axes[:, 0] = plane
    axes[:, 1:4] = np.eye(3)
    axes[:, 4:] = np.cross(np.eye(3)[None, :, None, :], edges[:, None, :, :]).reshape(-1, 9, 3)
    length = np.sqrt(dot(axes, axes))
    scale = np.sqrt(dot(edges, edges)).max(axis=1)
    usable = length > 1e-6 * np.concatenate([scale[:, None] ** 2, np.ones((len(local), 3)), np.repeat(scale[:, None], 9, axis=1)], axis=1)
    axes /= np.where(usable, length, 1.0)[:, :, None]
    heights = np.einsum("nai,nki->nak", axes, local)
    extent = np.einsum("nai,ni->na", np.abs(axes), half)
    low, high = heights.min(axis=2), heights.max(axis=2)
    # From the box to the triangle along +axis and along -axis.
    ahead, behind = low - extent, -high - extent
    distance = np.where(usable, np.maximum(ahead, behind), -np.inf)
    sign = np.where(ahead >= behind, 1.0, -1.0)
    row = np.arange(len(local))
    worth = distance.copy()
    worth[:, 4:] -= FACE_PREFERENCE
    best = worth.argmax(axis=1)
    distance = distance[row, best]
    normal = axes[row, best] * sign[row, best][:, None]
    first = _support(normal, half, local.mean(axis=1))
    corner_heights = np.einsum("ni,nki->nk", normal, local)
    lowest = corner_heights <= corner_heights.min(axis=1, keepdims=True) + 1e-7
    weight = lowest / lowest.sum(axis=1, keepdims=True)
    second = np.einsum("nk,nki->ni", weight, local)

    near_box = second - normal * distance[:, None]
    over_box = (np.abs(near_box) <= half + 1e-9).all(axis=1)
    foot = first + normal * distance[:, None]
    over_triangle = np.ones(len(row), dtype=np.bool_)
    for k in range(3):
        over_triangle &= dot(np.cross(edges[:, k], foot - local[:, k]), plane) >= -1e-9 * scale**3
    of_plane, of_box = best == 0, (best > 0) & (best < 4)
    exact = (of_plane & over_triangle) | (of_box & over_box) | (distance <= 0)
    second = np.where(of_plane[:, None], foot, second)
    first = np.where(of_box[:, None], near_box, first)
    return AxisSeparation(
        Separation(distance, turned(rotation, normal), turned(rotation, first) + centre, turned(rotation, second) + centre), exact
    )
