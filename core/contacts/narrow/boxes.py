"""Contacts of pairs of boxes, thousands at a time: separating axes, then the common area of the two faces that meet.

Arrays have the pairs along their last axis, and everything is in the frame of the first box. Where two faces meet, the face of the axis is
the rectangle |u| <= p, |v| <= q; the other box's face is a parallelogram over it at heights that are linear. Their intersection need not be
put in order: its area and centre are integrals along its boundary (Green's theorem), which consists of the parts of either outline that lie
inside the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray
from .manifold import PATCH_GAP, patch_gap

_FACE_PREFERENCE = 1e-6
"""Metres by which an axis of two edges must be better than that of a face to be taken."""

_FACING = 0.7
"""Cosine of the angle between an edge axis and a face's normal from which on the patch is that of the face (45 degrees)."""

_CERTAIN = 1e-4
"""Metres by which a lower bound on a distance may be below an upper bound and still pass for it."""

_EDGE = 1e-9
"""Part of a face's size by which outlines that coincide are told apart."""

_LEAST_WEIGHT = 1e-3
"""Weight of the nearest points of two edges, or of a sliver, beside corners of either box that are as near."""

_SLIVER = 0.005
"""Metres of width below which the centre of a patch goes over to the mean of the nearest corners."""

_OF_EDGES = 100
"""Added to the number of a face whose patch is wanted though edges are nearest."""

_NEXT = np.array([1, 2, 0])
_AFTER = np.array([2, 0, 1])
_TURNS = np.stack([_NEXT, _AFTER, np.arange(3)])
_COLUMN = np.arange(3)[:, None]
_SIGNS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]).T  # corners of a box
# Corners of a face in turn, from one to the next along its first or its second direction.
_START = np.array([[-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0]])[:, :, None]
_WAY = np.array([[2.0, 0.0, -2.0, 0.0], [0.0, 2.0, 0.0, -2.0]])[:, :, None]


@dataclass(frozen=True, slots=True)
class BoxContacts:
    """Per pair: signed ``distance`` (p,), ``normal`` (3, p) from first to second, ``centre`` (3, p) of the patch midway between the
    surfaces, ``area`` (p,), and ``exact`` (p,) False where the distance is but a lower bound and the rest is not to be used."""

    distance: FloatArray
    normal: FloatArray
    centre: FloatArray
    area: FloatArray
    exact: BoolArray


@dataclass(frozen=True, slots=True)
class _Axes:
    """Best axes: ``distance`` (p,); ``axis`` (p,) 0-2 a face of the first, 3-5 of the second, 6-14 edges ``3 i + j``."""

    distance: FloatArray
    axis: IntArray


def best_axes(rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray) -> _Axes:
    """Greatest separation of boxes over their axes: rotation (3, 3, p) and centre (3, p) of the second in the frame of the first, half
    extents (3, p)."""
    size = np.abs(rotation)
    offset_b = np.einsum("ijp,ip->jp", rotation, offset)
    worth = np.empty((15, offset.shape[1]))
    np.subtract(np.abs(offset), half_a + np.einsum("ijp,jp->ip", size, half_b), out=worth[:3])
    np.subtract(np.abs(offset_b), half_b + np.einsum("ijp,ip->jp", size, half_a), out=worth[3:6])
    # Axis i of the first x axis j of the second: e_i x r_j, with r_j column j of the rotation.
    turned_1, turned_2, size_1, size_2 = rotation[_NEXT], rotation[_AFTER], size[_NEXT], size[_AFTER]
    along = offset[_AFTER, None] * turned_1 - offset[_NEXT, None] * turned_2
    reach = half_a[_NEXT, None] * size_2 + half_a[_AFTER, None] * size_1
    reach += half_b[_NEXT] * size[:, _AFTER] + half_b[_AFTER] * size[:, _NEXT]
    squared = turned_1 * turned_1 + turned_2 * turned_2
    edges = (np.abs(along) - reach) / np.sqrt(np.maximum(squared, 1e-8)) - _FACE_PREFERENCE
    edges[squared < 1e-8] = -np.inf
    worth[6:] = edges.reshape(9, -1)
    axis = worth.argmax(axis=0)
    distance = _pick(worth, axis)
    distance += np.where(axis < 6, 0.0, _FACE_PREFERENCE)
    return _Axes(distance, axis)


def box_contacts(rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray, reach: FloatArray) -> BoxContacts:
    """Contacts of boxes: rotation (3, 3, p) and centre (3, p) of the second in the frame of the first, half extents (3, p) > 0. Beyond
    ``reach`` (p,) only a lower bound on the distance is given."""
    best = best_axes(rotation, offset, half_a, half_b)
    count = len(best.distance)
    result = BoxContacts(best.distance, np.zeros((3, count)), np.zeros((3, count)), np.zeros(count), best.distance > reach)
    result.normal[2] = 1.0
    axis = best.axis
    near = best.distance <= reach
    edges = np.flatnonzero(near & (axis >= 6))
    if len(edges):
        boxes = _rows(edges, rotation, offset, half_a, half_b)
        _edges(result, edges, axis[edges] - 6, *boxes)
        # Where the faces that the edges belong to are all but parallel, the patch is theirs.
        normal = result.normal[:, edges]
        alignment = np.abs(np.concatenate([normal, np.einsum("ijp,ip->jp", boxes[0], normal)]))
        face = alignment.argmax(axis=0)
        axis[edges] = np.where(_pick(alignment, face) > _FACING, face + _OF_EDGES, 6)
    faces = np.flatnonzero(near & (axis != 6))
    if len(faces):
        _faces(result, faces, axis[faces], *_rows(faces, rotation, offset, half_a, half_b))
    return result


def _rows(
    rows: IntArray, rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Some of the pairs."""
    if len(rows) == offset.shape[1]:
        return rotation, offset, half_a, half_b
    return rotation.take(rows, axis=2), offset.take(rows, axis=1), half_a.take(rows, axis=1), half_b.take(rows, axis=1)


def _pick(values: FloatArray, index: IntArray) -> FloatArray:
    """``values[index[..., p], p]`` of arrays (k, p)."""
    count = values.shape[1]
    return np.asarray(values.reshape(-1).take(index * count + np.arange(count)))


def _faces(
    result: BoxContacts, rows: IntArray, axis: IntArray, rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray
) -> None:
    """Pairs with the ``axis`` of a face; of those whose edges are nearest only the patch. ``face`` is the box that the face belongs to,
    ``other`` comes towards it."""
    by_edges = axis >= _OF_EDGES
    axis = np.where(by_edges, axis - _OF_EDGES, axis)
    of_a = axis < 3
    turn = np.where(of_a, rotation, rotation.transpose(1, 0, 2)).reshape(9, -1)
    shift = np.where(of_a, offset, -np.einsum("ijp,ip->jp", rotation, offset))
    face, other = np.where(of_a, half_a, half_b), np.where(of_a, half_b, half_a)
    # Both boxes with the axes in turn such that the third ones are those that meet.
    k = np.where(of_a, axis, axis - 3)
    i = _TURNS[:, k]
    j = _TURNS[:, np.abs(_pick(turn, 3 * k + _COLUMN)).argmax(axis=0)]
    turn = _pick(turn, 3 * i[:, None] + j)
    shift, face, other = _pick(shift, i), _pick(face, i), _pick(other, j)
    side = np.where(shift[2] < 0, -1.0, 1.0)
    down = np.where(turn[2, 2] * side < 0, other[2], -other[2])
    # The other's face in units of the rectangle: centre and half edges, each as (u, v, height above the face).
    unit = np.stack([1.0 / face[0], 1.0 / face[1], side])
    centre = (shift + turn[:, 2] * down) * unit
    centre[2] -= face[2]
    slope = np.hypot(turn[0, 2], turn[1, 2]) / np.maximum(np.abs(turn[2, 2]), 1e-9)
    within = patch_gap(slope)
    area, u, v, lowest, found = _overlap(centre, turn[:, 0] * other[0] * unit, turn[:, 1] * other[1] * unit, within)
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
    normal = np.where(k == _COLUMN, np.where(of_a, side, -side), 0.0)
    # Those of the second box's faces are in its frame.
    back = np.flatnonzero(~of_a)
    if len(back):
        turn_back = rotation.take(back, axis=2)
        middle[:, back] = np.einsum("ijp,jp->ip", turn_back, middle[:, back]) + offset[:, back]
        normal[:, back] = np.einsum("ijp,jp->ip", turn_back, normal[:, back])
    # Slivers: no wider than what trembles.
    length = np.minimum(np.maximum(face[0], face[1]), np.maximum(other[0], other[1]))
    share = np.square(np.clip(1.0 - area / (2 * _SLIVER * length), 0.0, 1.0))
    narrow = np.flatnonzero((share > 0) & (exact | by_edges))
    if len(narrow):
        boxes = _rows(narrow, rotation, offset, half_a, half_b)
        mean = _mean_of_nearest(normal[:, narrow], middle[:, narrow], distance[narrow], *boxes)
        mean = np.where(by_edges[narrow], result.centre[:, rows[narrow]], mean)
        middle[:, narrow] += share[narrow] * (mean - middle[:, narrow])
    if by_edges.any():
        patched = np.flatnonzero(by_edges & (area > 0))
        result.centre[:, rows[patched]], result.area[rows[patched]] = middle[:, patched], area[patched]
        own = np.flatnonzero(~by_edges)
        rows, distance, normal, middle, area, exact = rows[own], distance[own], normal[:, own], middle[:, own], area[own], exact[own]
    result.distance[rows], result.area[rows], result.exact[rows] = distance, area, exact
    result.normal[:, rows], result.centre[:, rows] = normal, middle


_Overlap = tuple[FloatArray, FloatArray, FloatArray, FloatArray, BoolArray]


def _overlap(centre: FloatArray, first: FloatArray, second: FloatArray, within: FloatArray) -> _Overlap:
    """`_intersection`, where no more than one corner of the parallelogram is low enough, and over the square, in one step: the triangle
    there."""
    steps = within / np.maximum(np.abs(np.stack([first[2], second[2]])), 1e-12)
    low = np.where(np.stack([first[2], second[2]]) < 0, 1.0, -1.0)
    corner = centre + first * low[0] + second * low[1]
    leg_1, leg_2 = first * (low[0] * steps[0]), second * (low[1] * steps[1])
    span = np.abs(np.stack([corner, corner - leg_1, corner - leg_2])[:, :2])
    alone = (steps <= 2).all(axis=0) & (span <= 1).all(axis=(0, 1))
    area = np.abs(leg_1[0] * leg_2[1] - leg_1[1] * leg_2[0]) / 2
    u, v, _ = corner - (leg_1 + leg_2) / 3
    found = alone.copy()
    rest = np.flatnonzero(~alone)
    if len(rest):
        values = _intersection(centre.take(rest, axis=1), first.take(rest, axis=1), second.take(rest, axis=1), within[rest])
        for result, value in zip((area, u, v, corner[2], found), values, strict=True):
            result[rest] = value
    return area, u, v, corner[2], found


def _intersection(centre: FloatArray, first: FloatArray, second: FloatArray, within: FloatArray) -> _Overlap:
    """The part of the square |u|, |v| <= 1 under the parallelogram ``centre + s first + t second``, |s|, |t| <= 1, each (3, p) as (u, v,
    height), as far as its height is ``within`` (p,) of the least there: area, centre (u, v), least height, and whether there is
    any."""
    (cu, cv, cz), (e1u, e1v, e1z), (e2u, e2v, e2z) = centre, first, second
    count = len(cu)
    # Counter-clockwise.
    determinant = e1u * e2v - e1v * e2u
    sign = np.where(determinant < 0, -1.0, 1.0)
    e2u, e2v, e2z = e2u * sign, e2v * sign, e2z * sign
    inverse = 1.0 / np.maximum(np.abs(determinant), 1e-300)
    # Edges 0-3: of the parallelogram, to be inside the square. Edges 4-7: of the square, to be inside the parallelogram, in (s, t).
    begin, way = np.empty((5, 8, count)), np.empty((5, 8, count))  # u, v, z, and the two coordinates to be inside of
    begin[0, :4] = cu + _START[0] * e1u + _START[1] * e2u
    begin[1, :4] = cv + _START[0] * e1v + _START[1] * e2v
    begin[2, :4] = cz + _START[0] * e1z + _START[1] * e2z
    way[0, :4] = _WAY[0] * e1u + _WAY[1] * e2u
    way[1, :4] = _WAY[0] * e1v + _WAY[1] * e2v
    way[2, :4] = _WAY[0] * e1z + _WAY[1] * e2z
    begin[3:, :4], way[3:, :4] = begin[:2, :4], way[:2, :4]
    begin[:2, 4:], way[:2, 4:] = _START, _WAY
    du, dv = begin[0, 4:] - cu, begin[1, 4:] - cv
    f1, f2, g1, g2 = e2v * inverse, e2u * inverse, e1u * inverse, e1v * inverse
    begin[3, 4:] = du * f1 - dv * f2
    begin[4, 4:] = dv * g1 - du * g2
    way[3, 4:] = _WAY[0] * f1 - _WAY[1] * f2
    way[4, 4:] = _WAY[1] * g1 - _WAY[0] * g2
    begin[2, 4:] = cz + begin[3, 4:] * e1z + begin[4, 4:] * e2z
    way[2, 4:] = way[3, 4:] * e1z + way[4, 4:] * e2z
    step = way[3:]
    step[np.abs(step) < 1e-300] = 1e-300
    # Outlines that coincide count once: the one of the parallelogram. Both are moved by the same length, so that edges that cross at
    # next to no angle change over at one place.
    limit = np.empty((2, 8, count))
    limit[:, :4] = 1.0 + _EDGE
    limit[0, 4:] = 1.0 - _EDGE * np.hypot(f1, f2)
    limit[1, 4:] = 1.0 - _EDGE * np.hypot(g1, g2)
    low, high = -limit - begin[3:], limit - begin[3:]
    low /= step
    high /= step
    t0 = np.maximum(np.minimum(low, high).max(axis=0), 0.0)
    t1 = np.minimum(np.maximum(low, high, out=high).min(axis=0), 1.0)
    used = t1 > t0
    z, dz = begin[2], way[2]
    heights = np.where(dz < 0, t1, t0)
    heights *= dz
    heights += z
    heights[~used] = np.inf
    z_low = heights.min(axis=0)
    found = used.any(axis=0)
    # Leave out what is higher; the cut closes the outline from where it goes out to where it comes in.
    top = np.where(found, z_low, 0.0) + within
    at = (top - z) / np.where(np.abs(dz) < 1e-15, 1e-15, dz)
    used &= (np.abs(dz) > 1e-15) | (z <= top)
    leaves, enters = used & (dz > 1e-15) & (at < t1), used & (dz < -1e-15) & (at > t0)
    t1 = np.where(leaves, at, t1)
    t0 = np.where(enters, at, t0)
    used &= t1 > t0
    leaves &= used
    enters &= used
    u0, v0 = begin[0] + t0 * way[0], begin[1] + t0 * way[1]
    u1, v1 = begin[0] + t1 * way[0], begin[1] + t1 * way[1]
    weight = used.astype(np.float64)
    number = np.maximum(weight.sum(axis=0), 1.0)
    # About a point of the outline, so that little is lost where it is small.
    ou, ov = (u0 * weight).sum(axis=0) / number, (v0 * weight).sum(axis=0) / number
    u0, v0, u1, v1 = u0 - ou, v0 - ov, u1 - ou, v1 - ov
    cross = (u0 * v1 - v0 * u1) * weight
    out_u, out_v = (u1 * leaves).sum(axis=0), (v1 * leaves).sum(axis=0)
    in_u, in_v = (u0 * enters).sum(axis=0), (v0 * enters).sum(axis=0)
    closing = out_u * in_v - out_v * in_u
    total = cross.sum(axis=0) + closing
    moment_u = ((u0 + u1) * cross).sum(axis=0) + (out_u + in_u) * closing
    moment_v = ((v0 + v1) * cross).sum(axis=0) + (out_v + in_v) * closing
    solid = total > 1e-14
    divisor = 3.0 * np.where(solid, total, 1.0)
    mean_u, mean_v = ((u0 + u1) * used).sum(axis=0) / (2 * number), ((v0 + v1) * used).sum(axis=0) / (2 * number)
    mu = np.where(solid, moment_u / divisor, mean_u) + ou
    mv = np.where(solid, moment_v / divisor, mean_v) + ov
    return np.maximum(total, 0.0) / 2, np.clip(mu, -1.0, 1.0), np.clip(mv, -1.0, 1.0), z_low, found


def _edges(
    result: BoxContacts, rows: IntArray, edge: IntArray, rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray
) -> None:
    """Pairs whose best axis is square to edge i of the first and edge j of the second: the nearest points of the two."""
    i, j = edge // 3, edge % 3
    way = _pick(rotation.reshape(9, -1), 3 * _COLUMN + j)  # (3, p): direction of the second's edge
    of_i = i == _COLUMN
    normal = np.where(_NEXT[i] == _COLUMN, -_pick(way, _AFTER[i]), np.where(of_i, 0.0, _pick(way, _NEXT[i])))
    length = np.sqrt(np.einsum("ip,ip->p", normal, normal))
    normal /= np.where(np.einsum("ip,ip->p", normal, offset) < 0, -length, length)
    on_a = np.where(of_i, 0.0, np.where(normal < 0, -half_a, half_a))
    on_b = np.where(j == _COLUMN, 0.0, np.where(np.einsum("ijp,ip->jp", rotation, normal) < 0, half_b, -half_b))
    on_b = np.einsum("ijp,jp->ip", rotation, on_b) + offset
    between = on_b - on_a
    along_i, along_j, slant = _pick(between, i), np.einsum("ip,ip->p", between, way), _pick(way, i)
    area = 1.0 - slant * slant
    s, t = (along_i - slant * along_j) / area, (slant * along_i - along_j) / area
    most_s, most_t = _pick(half_a, i), _pick(half_b, j)
    within = (np.abs(s) <= most_s * (1 + _EDGE)) & (np.abs(t) <= most_t * (1 + _EDGE))
    on_a = np.where(of_i, np.clip(s, -most_s, most_s), on_a)
    on_b += way * np.clip(t, -most_t, most_t)
    result.normal[:, rows] = normal
    result.centre[:, rows] = _mean_of_nearest(normal, (on_a + on_b) / 2, result.distance[rows], rotation, offset, half_a, half_b)
    result.exact[rows] = within | (result.distance[rows] <= 0)


def _nearness(excess: FloatArray) -> FloatArray:
    """Weights of points that are further apart than the nearest ones by ``excess`` [m]: 1 there, 0 from ``PATCH_GAP`` on."""
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
    """The mean (3, p) of the corners that are as near to the other box or as deep in it along ``normal`` as the ``least`` distance, in the
    plane of ``middle``, which counts a little, too."""
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
    """Complete those contacts that are not exact: boxes apart whose nearest points are a corner of the one and any point of the other.

    Edges that face each other in parallel are as near all along; the centre is the mean of all the corners that are as near.
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
