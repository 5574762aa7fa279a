"""Contacts of pairs of boxes, thousands at a time: separating axes, then the common area of the two facing faces.

Arrays have the pairs along their last axis, and everything is in the frame of the first box. The face of the best axis is the rectangle
|u| <= p, |v| <= q; the other box's face is a parallelogram over it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray
from .box_axes import AFTER, FIRST_EDGE_AXIS, NEXT, best_axes, edge_points
from .frames import COLUMN, pick
from .manifold import PATCH_GAP, patch_gap
from .parallelogram import overlap

_FACING = 0.7
"""Cosine of the angle between an edge axis and a face's normal above which the patch is that of the face (45 degrees)."""

_CERTAIN = 1e-4
"""Metres between a lower and an upper bound on a distance up to which the lower bound counts as the distance."""

_LEAST_WEIGHT = 1e-3
"""Weight of the nearest points of two edges, or of a sliver, beside corners of either box that are as near."""

_SLIVER = 0.005
"""Metres of width below which the centre of a patch moves smoothly to the mean of the nearest corners."""

_OF_EDGES = 100
"""Added to the number of a face whose patch is sought although two edges are nearest."""

_TURNS = np.stack([NEXT, AFTER, np.arange(3)])
_SIGNS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]).T  # corners of a box


@dataclass(frozen=True, slots=True)
class BoxContacts:
    """Per pair: signed ``distance`` (p,), ``normal`` (3, p) from first to second, ``centre`` (3, p) of the patch midway between the
    surfaces, ``area`` (p,), and ``exact`` (p,): False where the distance is only a lower bound and the rest is undefined."""

    distance: FloatArray
    normal: FloatArray
    centre: FloatArray
    area: FloatArray
    exact: BoolArray


def box_contacts(rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray, limit: FloatArray) -> BoxContacts:
    """Contacts of boxes: rotation (3, 3, p) and centre (3, p) of the second in the frame of the first, half extents (3, p) > 0. Beyond
    ``limit`` (p,) only a lower bound on the distance is given."""
    best = best_axes(rotation, offset, half_a, half_b)
    count = len(best.distance)
    result = BoxContacts(best.distance, np.zeros((3, count)), np.zeros((3, count)), np.zeros(count), best.distance > limit)
    result.normal[2] = 1.0
    axis = best.axis
    # Each centre is ``lying`` where the faces overlap, moved by ``share`` of the way to the mean of the nearest corners.
    lying, share = result.centre.copy(), np.zeros(count)
    near = best.distance <= limit
    edges = np.flatnonzero(near & (axis >= FIRST_EDGE_AXIS))
    if len(edges):
        boxes = _rows(edges, rotation, offset, half_a, half_b)
        normal = _edges(result, edges, axis[edges], *boxes)
        lying[:, edges], share[edges] = result.centre[:, edges], 1.0
        # Where the faces that the edges belong to are nearly parallel, the patch is theirs.
        alignment = np.abs(np.concatenate([normal, np.einsum("ijp,ip->jp", boxes[0], normal)]))
        face = alignment.argmax(axis=0)
        axis[edges] = np.where(pick(alignment, face) > _FACING, face + _OF_EDGES, FIRST_EDGE_AXIS)
    faces = np.flatnonzero(near & (axis != FIRST_EDGE_AXIS))
    if len(faces):
        _faces(result, lying, share, faces, axis[faces], *_rows(faces, rotation, offset, half_a, half_b))
    narrow = np.flatnonzero(share > 0)
    if len(narrow):
        found = result.normal.take(narrow, axis=1), result.centre.take(narrow, axis=1), result.distance[narrow]
        mean = _mean_of_nearest(*found, *_rows(narrow, rotation, offset, half_a, half_b))
        lying[:, narrow] += share[narrow] * (mean - lying[:, narrow])
    return BoxContacts(result.distance, result.normal, lying, result.area, result.exact)


def _rows(
    rows: IntArray, rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Some of the pairs."""
    if len(rows) == offset.shape[1]:
        return rotation, offset, half_a, half_b
    return rotation.take(rows, axis=2), offset.take(rows, axis=1), half_a.take(rows, axis=1), half_b.take(rows, axis=1)


def _faces(
    result: BoxContacts,
    lying: FloatArray,
    share: FloatArray,
    rows: IntArray,
    axis: IntArray,
    rotation: FloatArray,
    offset: FloatArray,
    half_a: FloatArray,
    half_b: FloatArray,
) -> None:
    """Contacts of the pairs with the ``axis`` of a face; where edges are nearest, their patch alone. ``face`` is the box that the face
    belongs to, ``other`` the box over it."""
    by_edges = axis >= _OF_EDGES
    axis = np.where(by_edges, axis - _OF_EDGES, axis)
    of_a = axis < 3
    turn = np.where(of_a, rotation, rotation.transpose(1, 0, 2)).reshape(9, -1)
    shift = np.where(of_a, offset, -np.einsum("ijp,ip->jp", rotation, offset))
    face, other = np.where(of_a, half_a, half_b), np.where(of_a, half_b, half_a)
    # Both boxes with their axes permuted so that the third ones face each other.
    k = np.where(of_a, axis, axis - 3)
    i = _TURNS[:, k]
    j = _TURNS[:, np.abs(pick(turn, 3 * k + COLUMN)).argmax(axis=0)]
    turn = pick(turn, 3 * i[:, None] + j)
    shift, face, other = pick(shift, i), pick(face, i), pick(other, j)
    side = np.where(shift[2] < 0, -1.0, 1.0)
    down = np.where(turn[2, 2] * side < 0, other[2], -other[2])
    # The other's face in units of the rectangle: centre and half edges, each as (u, v, height above the face).
    unit = np.stack([1.0 / face[0], 1.0 / face[1], side])
    centre = (shift + turn[:, 2] * down) * unit
    centre[2] -= face[2]
    slope = np.hypot(turn[0, 2], turn[1, 2]) / np.maximum(np.abs(turn[2, 2]), 1e-9)
    within = patch_gap(slope)
    area, u, v, lowest, found = overlap(centre, turn[:, 0] * other[0] * unit, turn[:, 1] * other[1] * unit, within)
    area = area * face[0] * face[1]
    distance = result.distance[rows]
    lifted = lowest - distance
    apart = distance > 0
    exact = found & (~apart | (lifted <= _CERTAIN))
    distance = np.where(apart & exact & (lifted > 0) & ~by_edges, distance + lifted, distance)
    local = np.stack([u * face[0], v * face[1], side * (face[2] + distance / 2)])
    count = len(rows)
    middle = np.empty((3, count))
    middle.reshape(-1)[i * count + np.arange(count)] = local
    normal = np.where(k == COLUMN, np.where(of_a, side, -side), 0.0)
    # Where the face is the second box's, from its frame to that of the first.
    back = np.flatnonzero(~of_a)
    if len(back):
        turn_back = rotation.take(back, axis=2)
        middle[:, back] = np.einsum("ijp,jp->ip", turn_back, middle[:, back]) + offset[:, back]
        normal[:, back] = np.einsum("ijp,jp->ip", turn_back, normal[:, back])
    # The centre of a sliver would jump as the bodies tremble.
    length = np.minimum(np.maximum(face[0], face[1]), np.maximum(other[0], other[1]))
    thin = np.where(exact | by_edges, np.square(np.clip(1.0 - area / (2 * _SLIVER * length), 0.0, 1.0)), 0.0)
    if by_edges.any():
        patched = np.flatnonzero(by_edges & (area > 0))
        over = rows[patched]
        lying[:, over], share[over], result.area[over] = middle[:, patched], thin[patched], area[patched]
        own = np.flatnonzero(~by_edges)
        rows, distance, normal, middle, area = rows[own], distance[own], normal[:, own], middle[:, own], area[own]
        exact, thin = exact[own], thin[own]
    result.distance[rows], result.area[rows], result.exact[rows], share[rows] = distance, area, exact, thin
    result.normal[:, rows] = normal
    result.centre[:, rows] = lying[:, rows] = middle


def _edges(
    result: BoxContacts, rows: IntArray, axis: IntArray, rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray
) -> FloatArray:
    """Pairs whose best axis is that of two edges: the nearest points of the two. Returns the normals."""
    points = edge_points(axis, rotation, offset, half_a, half_b)
    result.normal[:, rows], result.centre[:, rows] = points.normal, (points.first + points.second) / 2
    result.exact[rows] = points.within | (result.distance[rows] <= 0)
    return points.normal


def _nearness(excess: FloatArray) -> FloatArray:
    """Weights of points that are ``excess`` metres further apart than the nearest ones: 1 at 0, 0 from ``PATCH_GAP`` on."""
    return np.square(np.clip(1.0 - excess / PATCH_GAP, 0.0, 1.0))


@dataclass(frozen=True, slots=True)
class _Corners:
    """The 16 corners of two boxes, those of the second first: ``distance`` (16, p) to the other box, points ``middle`` (3, 16, p) midway to
    it, and vectors ``way`` (3, 16, p) from the first box to the second."""

    distance: FloatArray
    middle: FloatArray
    way: FloatArray


def _corners(rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray) -> _Corners:
    of_b = offset[:, None] + np.einsum("ijp,jkp->ikp", rotation, _SIGNS[..., None] * half_b[:, None])
    on_a = np.clip(of_b, -half_a[:, None], half_a[:, None])
    of_a = _SIGNS[..., None] * half_a[:, None]
    local = np.einsum("ijp,ikp->jkp", rotation, of_a - offset[:, None])
    on_b = offset[:, None] + np.einsum("ijp,jkp->ikp", rotation, np.clip(local, -half_b[:, None], half_b[:, None]))
    first, second = np.concatenate([on_a, of_a], axis=1), np.concatenate([of_b, on_b], axis=1)
    way = second - first
    return _Corners(np.sqrt(np.einsum("ikp,ikp->kp", way, way)), (first + second) / 2, way)


def _mean_of_nearest(
    normal: FloatArray,
    middle: FloatArray,
    least: FloatArray,
    rotation: FloatArray,
    offset: FloatArray,
    half_a: FloatArray,
    half_b: FloatArray,
) -> FloatArray:
    """Weighted mean (3, p) of the corners whose distance to the other box, or depth in it along ``normal``, is nearly the ``least``, moved
    into the plane of ``middle``, which has a small weight of its own."""
    corners = _corners(rotation, offset, half_a, half_b)
    top = np.einsum("ip,ip->p", np.abs(normal), half_a)
    bottom = np.einsum("ip,ip->p", normal, offset) - np.einsum("ip,ip->p", np.abs(np.einsum("ijp,ip->jp", rotation, normal)), half_b)
    height = np.einsum("ip,ikp->kp", normal, corners.middle + corners.way / 2)
    other = np.einsum("ip,ikp->kp", normal, corners.middle - corners.way / 2)
    depth = np.concatenate([height[:8] - top, bottom - other[8:]])
    beside = np.clip(1.0 - corners.distance / PATCH_GAP, 0.0, 1.0)  # 0 for corners that are past the other box
    distance = corners.distance + np.minimum(depth, 0.0) * beside
    weight = _nearness(distance - least)
    mean = (_LEAST_WEIGHT * middle + np.einsum("kp,ikp->ip", weight, corners.middle)) / (_LEAST_WEIGHT + weight.sum(axis=0))
    return np.asarray(mean + normal * np.einsum("ip,ip->p", normal, middle - mean))


def corner_contacts(result: BoxContacts, rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray) -> None:
    """Complete the contacts that are not exact: boxes apart whose nearest points are a corner of one and any point of the other.

    Parallel edges that face each other are equally near all along; the centre is the mean of all the corners that are as near.
    """
    rows = np.flatnonzero(~result.exact)
    if len(rows) == 0:
        return
    corners = _corners(*_rows(rows, rotation, offset, half_a, half_b))
    distance = corners.distance.min(axis=0)
    weight = _nearness(corners.distance - distance)
    normal = np.einsum("kp,ikp->ip", weight / np.maximum(corners.distance, 1e-12), corners.way)
    length = np.sqrt(np.einsum("ip,ip->p", normal, normal))
    apart = length > 0
    result.distance[rows] = distance
    result.normal[:, rows] = np.where(apart, normal / np.where(apart, length, 1.0), result.normal[:, rows])
    result.centre[:, rows] = np.einsum("kp,ikp->ip", weight, corners.middle) / weight.sum(axis=0)
    result.area[rows] = 0.0
