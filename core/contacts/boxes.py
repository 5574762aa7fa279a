"""Contacts of pairs of boxes, thousands at a time: separating axes, then the common area of the two faces that meet.

Arrays have the pairs along their last axis, and everything is in the frame of the first box. Where two faces meet, the face of the axis is
the rectangle |u| <= p, |v| <= q; the other box's face is a parallelogram over it at heights that are linear. Their intersection need not be
put in order: its area and centre are integrals along its boundary (Green's theorem), which consists of the parts of either outline that lie
inside the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .patch import PATCH_GAP

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

_FACE_PREFERENCE = 1e-6
"""Metres by which an axis of two edges must be better than that of a face to be taken."""

_FLAT = 0.9998
"""Cosine of the angle between an edge axis and a face's normal from which on the patch is that of the face (1 degree)."""

_CERTAIN = 1e-4
"""Metres by which a lower bound on a distance may be below an upper bound and still pass for it."""

_EDGE = 1e-9
"""Part of a face's size by which outlines that coincide are told apart."""

_NEXT = np.array([1, 2, 0])
_AFTER = np.array([2, 0, 1])
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
    offset_b = (rotation * offset[:, None]).sum(axis=0)
    worth = np.empty((15, offset.shape[1]))
    np.subtract(np.abs(offset), half_a + (size * half_b).sum(axis=1), out=worth[:3])
    np.subtract(np.abs(offset_b), half_b + (size * half_a[:, None]).sum(axis=0), out=worth[3:6])
    # Axis i of the first x axis j of the second: e_i x r_j, with r_j column j of the rotation, has length sqrt(1 - r_ij^2).
    turned_1, turned_2, size_1, size_2 = rotation[_NEXT], rotation[_AFTER], size[_NEXT], size[_AFTER]
    along = offset[_AFTER, None] * turned_1 - offset[_NEXT, None] * turned_2
    reach = half_a[_NEXT, None] * size_2 + half_a[_AFTER, None] * size_1
    reach += half_b[_NEXT] * size[:, _AFTER] + half_b[_AFTER] * size[:, _NEXT]
    squared = 1.0 - size * size
    edges = (np.abs(along) - reach) / np.sqrt(np.maximum(squared, 1e-8)) - _FACE_PREFERENCE
    edges[squared < 1e-8] = -np.inf
    worth[6:] = edges.reshape(9, -1)
    axis = worth.argmax(axis=0)
    distance = np.take_along_axis(worth, axis[None], axis=0)[0]
    distance += np.where(axis < 6, 0.0, _FACE_PREFERENCE)
    return _Axes(distance, axis)


def box_contacts(rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray, reach: FloatArray) -> BoxContacts:
    """Contacts of boxes: rotation (3, 3, p) and centre (3, p) of the second in the frame of the first, half extents (3, p) > 0. Beyond
    ``reach`` (p,) only a lower bound on the distance is given."""
    best = best_axes(rotation, offset, half_a, half_b)
    count = len(best.distance)
    result = BoxContacts(best.distance, np.zeros((3, count)), np.zeros((3, count)), np.zeros(count), best.distance > reach)
    result.normal[2] = 1.0
    faces = np.flatnonzero((best.distance <= reach) & (best.axis < 6))
    if len(faces):
        everything = len(faces) == count
        of = (slice(None),) if everything else (faces,)
        _faces(result, faces, best.axis[faces], rotation[..., of[0]], offset[:, of[0]], half_a[:, of[0]], half_b[:, of[0]])
    edges = np.flatnonzero((best.distance <= reach) & (best.axis >= 6))
    if len(edges):
        boxes = (rotation[..., edges], offset[:, edges], half_a[:, edges], half_b[:, edges])
        _edges(result, edges, best.axis[edges] - 6, *boxes)
        _flatten(result, edges, *boxes)
    return result


def _flatten(result: BoxContacts, rows: IntArray, rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray) -> None:
    """Give pairs whose edges meet, but whose faces there are all but parallel, the patch of the faces."""
    normal = result.normal[:, rows]
    alignment = np.abs(np.concatenate([normal, (rotation * normal[:, None]).sum(axis=0)]))
    flat = np.flatnonzero(alignment.max(axis=0) > _FLAT)
    if len(flat) == 0:
        return
    patch = BoxContacts(result.distance[rows[flat]], normal[:, flat], np.zeros((3, len(flat))), np.zeros(len(flat)), flat > 0)
    boxes = (rotation[..., flat], offset[:, flat], half_a[:, flat], half_b[:, flat])
    _faces(patch, np.arange(len(flat)), alignment[:, flat].argmax(axis=0), *boxes)
    faced = np.flatnonzero(patch.area > 0)
    result.centre[:, rows[flat[faced]]] = patch.centre[:, faced]
    result.area[rows[flat[faced]]] = patch.area[faced]


def _pick(values: FloatArray, index: IntArray) -> FloatArray:
    """``values[index[p], ..., p]`` of (3, ..., p) arrays."""
    shape = (1,) * (values.ndim - 1) + index.shape
    return np.asarray(np.take_along_axis(values, index.reshape(shape), axis=0)[0])


def _faces(
    result: BoxContacts, rows: IntArray, axis: IntArray, rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray
) -> None:
    """Pairs whose best axis is a face's. ``face`` is the box that it belongs to, ``other`` comes towards it."""
    of_a = axis < 3
    k = np.where(of_a, axis, axis - 3)
    turn = np.where(of_a, rotation, rotation.transpose(1, 0, 2))
    shift = np.where(of_a, offset, -(rotation * offset[:, None]).sum(axis=0))
    face, other = np.where(of_a, half_a, half_b), np.where(of_a, half_b, half_a)
    k1, k2 = _NEXT[k], _AFTER[k]
    side = np.where(_pick(shift, k) < 0, -1.0, 1.0)
    p, q, h = _pick(face, k1), _pick(face, k2), _pick(face, k)
    along = _pick(turn, k)  # (3, p): heights of the other's axes
    u_of, v_of = _pick(turn, k1), _pick(turn, k2)
    j = np.abs(along).argmax(axis=0)
    j1, j2 = _NEXT[j], _AFTER[j]
    a, b = _pick(other, j1), _pick(other, j2)
    down = -side * np.where(_pick(along, j) < 0, -1.0, 1.0) * _pick(other, j)
    # The other's face: centre, half edges (in units of the rectangle's half sides) and heights above the face.
    cu = (_pick(shift, k1) + _pick(u_of, j) * down) / p
    cv = (_pick(shift, k2) + _pick(v_of, j) * down) / q
    cz = side * (_pick(shift, k) + _pick(along, j) * down) - h
    e1u, e1v, e1z = _pick(u_of, j1) * a / p, _pick(v_of, j1) * a / q, _pick(along, j1) * a * side
    e2u, e2v, e2z = _pick(u_of, j2) * b / p, _pick(v_of, j2) * b / q, _pick(along, j2) * b * side
    area, mu, mv, z_low, found = _intersection(cu, cv, cz, e1u, e1v, e1z, e2u, e2v, e2z)
    distance = result.distance[rows]
    lifted = np.maximum(z_low - distance, 0.0)
    apart = distance > 0
    exact = found & (~apart | (lifted <= _CERTAIN))
    distance = np.where(apart & exact, distance + lifted, distance)
    middle = np.empty_like(shift)
    for index, value in ((k1, mu * p), (k2, mv * q), (k, side * (h + distance / 2))):
        np.put_along_axis(middle, index[None], value[None], axis=0)
    normal = np.zeros_like(shift)
    np.put_along_axis(normal, k[None], (side * np.where(of_a, 1.0, -1.0))[None], axis=0)
    # Those of the second box's faces are in its frame.
    back = np.flatnonzero(~of_a)
    if len(back):
        turn_back = rotation[..., back]
        middle[:, back] = (turn_back * middle[:, back]).sum(axis=1) + offset[:, back]
        normal[:, back] = (turn_back * normal[:, back]).sum(axis=1)
    result.distance[rows] = distance
    result.normal[:, rows] = normal
    result.centre[:, rows] = middle
    result.area[rows] = area * p * q
    result.exact[rows] = exact


def _intersection(
    cu: FloatArray,
    cv: FloatArray,
    cz: FloatArray,
    e1u: FloatArray,
    e1v: FloatArray,
    e1z: FloatArray,
    e2u: FloatArray,
    e2v: FloatArray,
    e2z: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, BoolArray]:
    """The part of the square |u|, |v| <= 1 under the parallelogram ``c + s e1 + t e2``, |s|, |t| <= 1, as far as its height is within
    ``PATCH_GAP`` of the least there: area, centre (u, v), least height, and whether there is any."""
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
    slab, step = begin[3:], way[3:]
    step = np.where(np.abs(step) < 1e-300, 1e-300, step)
    low, high = (-_LIMIT - slab) / step, (_LIMIT - slab) / step
    t0 = np.maximum(np.minimum(low, high).max(axis=0), 0.0)
    t1 = np.minimum(np.maximum(low, high).min(axis=0), 1.0)
    used = t1 > t0
    z, dz = begin[2], way[2]
    heights = z + np.where(dz < 0, t1, t0) * dz
    z_low = np.where(used, heights, np.inf).min(axis=0)
    found = used.any(axis=0)
    # Leave out what is higher; the cut closes the outline from where it goes out to where it comes in.
    top = np.where(found, z_low, 0.0) + PATCH_GAP
    at = (top - z) / np.where(np.abs(dz) < 1e-15, 1e-15, dz)
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


_LIMIT = np.repeat([1.0 + _EDGE, 1.0 - _EDGE], 4)[:, None]


def _edges(
    result: BoxContacts, rows: IntArray, edge: IntArray, rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray
) -> None:
    """Pairs whose best axis is square to edge i of the first and edge j of the second: the nearest points of the two."""
    i, j = edge // 3, edge % 3
    way = _pick(rotation.transpose(1, 0, 2), j)  # (3, p): direction of the second's edge
    normal = np.zeros_like(offset)
    np.put_along_axis(normal, _NEXT[i][None], -_pick(way, _AFTER[i])[None], axis=0)
    np.put_along_axis(normal, _AFTER[i][None], _pick(way, _NEXT[i])[None], axis=0)
    normal /= np.sqrt((normal * normal).sum(axis=0)) * np.where((normal * offset).sum(axis=0) < 0, -1.0, 1.0)
    on_a = np.where(normal < 0, -half_a, half_a)
    np.put_along_axis(on_a, i[None], 0.0, axis=0)
    normal_b = (rotation * normal[:, None]).sum(axis=0)
    on_b = np.where(normal_b < 0, half_b, -half_b)
    np.put_along_axis(on_b, j[None], 0.0, axis=0)
    on_b = (rotation * on_b).sum(axis=1) + offset
    between = on_b - on_a
    along_i, along_j, slant = _pick(between, i), (between * way).sum(axis=0), _pick(way, i)
    area = 1.0 - slant * slant
    s, t = (along_i - slant * along_j) / area, (slant * along_i - along_j) / area
    most_s, most_t = _pick(half_a, i), _pick(half_b, j)
    within = (np.abs(s) <= most_s * (1 + _EDGE)) & (np.abs(t) <= most_t * (1 + _EDGE))
    np.put_along_axis(on_a, i[None], np.clip(s, -most_s, most_s)[None], axis=0)
    on_b += way * np.clip(t, -most_t, most_t)
    distance = result.distance[rows]
    result.normal[:, rows] = normal
    result.centre[:, rows] = (on_a + on_b) / 2
    result.exact[rows] = within | (distance <= 0)
