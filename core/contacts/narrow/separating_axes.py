"""Boxes against boxes and triangles by separating axes, many pairs at a time.

Of two polytopes that overlap, the least depth over the normals of their faces and the cross products of their edges is the exact depth. Of
two that are apart, the greatest separation over those axes is their distance where the nearest features face each other, and otherwise a
lower bound; ``exact`` says which.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray
from .closed_forms import Separation, dot, turned, turned_back

_FACE_PREFERENCE = 1e-6
"""Metres by which an axis of two edges must be better than that of a face to be taken."""


@dataclass(frozen=True, slots=True)
class AxisSeparation:
    """A ``separation`` and, per pair, whether its distance is ``exact`` (else it is a lower bound)."""

    separation: Separation
    exact: BoolArray


def box_to_box(
    rotation_a: FloatArray, centre_a: FloatArray, half_a: FloatArray, rotation_b: FloatArray, centre_b: FloatArray, half_b: FloatArray
) -> AxisSeparation:
    """Boxes (n pairs): rotations (n, 3, 3), centres (n, 3), half extents (n, 3), which may be 0."""
    row = np.arange(len(centre_a))
    relative = np.einsum("nji,njk->nik", rotation_a, rotation_b)
    offset = turned_back(rotation_a, centre_b - centre_a)
    size = np.abs(relative)
    # Faces of the first (3), faces of the second (3).
    faces = np.empty((len(row), 6))
    faces[:, :3] = np.abs(offset) - half_a - np.einsum("nij,nj->ni", size, half_b)
    offset_b = turned_back(relative, offset)
    faces[:, 3:] = np.abs(offset_b) - half_b - np.einsum("nij,ni->nj", size, half_a)
    face = faces.argmax(axis=1)
    face_distance = faces[row, face]
    # Edges: axis i of the first x axis j of the second. In the first's frame e_i x r_j, with r_j column j of the relative rotation.
    i1, i2 = _NEXT, _AFTER
    # Its length from its components: 1 - size^2 is not that of float32 rotations, nor 0 for parallel edges.
    length = np.sqrt(relative[:, i1, :] ** 2 + relative[:, i2, :] ** 2)
    usable = length > 1e-4
    along = offset[:, i2, None] * relative[:, i1, :] - offset[:, i1, None] * relative[:, i2, :]
    reach_a = half_a[:, i1, None] * size[:, i2, :] + half_a[:, i2, None] * size[:, i1, :]
    reach_b = half_b[:, None, i1] * size[:, :, i2] + half_b[:, None, i2] * size[:, :, i1]
    edges = np.where(usable, (np.abs(along) - reach_a - reach_b) / np.where(usable, length, 1.0), -np.inf).reshape(-1, 9)
    edge = edges.argmax(axis=1)
    edge_distance = edges[row, edge]
    by_edge = edge_distance > face_distance + _FACE_PREFERENCE

    distance = np.where(by_edge, edge_distance, face_distance)
    normal = np.zeros_like(offset)
    of_a = face < 3
    normal[of_a, face[of_a]] = 1.0
    chosen = np.flatnonzero(~of_a)
    normal[chosen] = relative[chosen, :, face[chosen] - 3]
    chosen = np.flatnonzero(by_edge)
    if len(chosen):
        i, j = edge[chosen] // 3, edge[chosen] % 3
        unit = np.eye(3)[i]
        cross = np.cross(unit, relative[chosen, :, j])
        normal[chosen] = cross / np.sqrt(dot(cross, cross))[:, None]
    normal *= np.where(dot(normal, offset) < 0, -1.0, 1.0)[:, None]

    # Supporting points, in the first's frame. An axis along which all points are equally far takes the coordinate nearest the other box.
    other_in_b = -offset_b
    first = _support(normal, half_a, offset)
    normal_b = turned_back(relative, normal)
    second_in_b = _support(-normal_b, half_b, other_in_b)
    second = turned(relative, second_in_b) + offset
    inside = np.zeros(len(row), dtype=np.bool_)
    # Face of the first: the second's supporting point must lie over that face; and the other way round.
    near_a = second - normal * distance[:, None]
    over_a = (np.abs(near_a) <= half_a + 1e-9).all(axis=1)
    near_b = turned_back(relative, first + normal * distance[:, None] - offset)
    over_b = (np.abs(near_b) <= half_b + 1e-9).all(axis=1)
    pick_a = ~by_edge & of_a
    pick_b = ~by_edge & ~of_a
    first[pick_a] = near_a[pick_a]
    second[pick_b] = (first + normal * distance[:, None])[pick_b]
    inside = (pick_a & over_a) | (pick_b & over_b)
    if len(chosen):
        edge_a, edge_b = (first[chosen], i, half_a[chosen]), (second_in_b[chosen], j, half_b[chosen])
        first[chosen], second[chosen], inside[chosen] = _edge_points(*edge_a, *edge_b, relative[chosen], offset[chosen])
    world_normal = turned(rotation_a, normal)
    return AxisSeparation(
        Separation(distance, world_normal, turned(rotation_a, first) + centre_a, turned(rotation_a, second) + centre_a),
        inside | (distance <= 0),
    )


_NEXT = np.array([1, 2, 0])
_AFTER = np.array([2, 0, 1])


def _support(direction: FloatArray, half: FloatArray, towards: FloatArray) -> FloatArray:
    """The point of a box farthest along ``direction``; along its axes that are square to it, as near ``towards`` as the box goes."""
    free = np.clip(towards, -half, half)
    return np.where(np.abs(direction) < 1e-7, free, np.where(direction < 0, -half, half))


def _edge_points(
    first: FloatArray,
    i: IntArray,
    half_a: FloatArray,
    second_in_b: FloatArray,
    j: IntArray,
    half_b: FloatArray,
    relative: FloatArray,
    offset: FloatArray,
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Nearest points of the lines of edge i of the first and edge j of the second, and whether both lie within their edges."""
    row = np.arange(len(first))
    p = first.copy()
    p[row, i] = 0.0
    q_in_b = second_in_b.copy()
    q_in_b[row, j] = 0.0
    q = turned(relative, q_in_b) + offset
    v = relative[row, :, j]
    w = q - p
    along_u = w[row, i]
    uv = v[row, i]
    along_v = dot(w, v)
    area = 1.0 - uv * uv
    s = (along_u - uv * along_v) / area
    t = (uv * along_u - along_v) / area
    limit_a, limit_b = half_a[row, i], half_b[row, j]
    within = (np.abs(s) <= limit_a + 1e-9) & (np.abs(t) <= limit_b + 1e-9)
    p[row, i] = np.clip(s, -limit_a, limit_a)
    return p, q + v * np.clip(t, -limit_b, limit_b)[:, None], within


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
    reach = np.einsum("nai,ni->na", np.abs(axes), half)
    low, high = heights.min(axis=2), heights.max(axis=2)
    # From the box to the triangle along +axis and along -axis.
    ahead, behind = low - reach, -high - reach
    distance = np.where(usable, np.maximum(ahead, behind), -np.inf)
    sign = np.where(ahead >= behind, 1.0, -1.0)
    row = np.arange(len(local))
    worth = distance.copy()
    worth[:, 4:] -= _FACE_PREFERENCE
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
