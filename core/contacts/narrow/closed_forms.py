"""Distances between simple cores in closed form, many pairs at a time.

Arrays have the pairs along their last axis: points (3, n), rotations (3, 3, n), triangles (3, 3, n)
by coordinate and corner. All is in world space and metres. Points, segments and triangles have no
inside; a point in a box has a negative distance, down to its nearest face.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray, chosen_of, joined, taken
from ...frozen import frozen
from .frames import COLUMN, cross, dot, following, pick, turned, turned_back

_UP = np.array([[0.0], [0.0], [1.0]])


@frozen
class Separation:
    """Signed ``distance`` (n,), unit ``normal`` (3, n) from first to second, nearest points
    ``first`` and ``second`` (3, n) on the cores."""

    distance: FloatArray
    normal: FloatArray
    first: FloatArray
    second: FloatArray


def between(
    first: FloatArray,
    second: FloatArray,
    otherwise: Callable[[IntArray], FloatArray] = lambda _: _UP,
) -> Separation:
    """The separation of nearest points. Of those pairs (m,) that coincide the normals (3, m) are
    what ``otherwise`` gives."""
    way = second - first
    distance = np.sqrt(dot(way, way))
    apart = distance > 1e-12
    normal = way / np.where(apart, distance, 1.0)
    if not apart.all():
        touching = np.flatnonzero(~apart)
        normal[:, touching] = otherwise(touching)
    return Separation(distance, normal, first, second)


def point_to_box(
    point: FloatArray, rotation: FloatArray, centre: FloatArray, half: FloatArray
) -> Separation:
    """Points (3, n) and boxes of half extents (3, n)."""
    local = turned_back(rotation, point - centre)
    outside = between(local, np.clip(local, -half, half))
    room = half - np.abs(local)
    axis = room.argmin(axis=0)
    inside = np.all(room > 0, axis=0)
    side = np.where(pick(local, axis) < 0, -1.0, 1.0)
    facing = axis == COLUMN
    face = np.where(facing, side * half, local)
    within = Separation(-pick(room, axis), np.where(facing, -side, 0.0), local, face)
    return _in_world(merged(outside, within, inside), rotation, centre)


def _in_world(local: Separation, rotation: FloatArray, centre: FloatArray) -> Separation:
    """The separation in world space of one in the space of its second cores."""
    ends = (turned(rotation, end) + centre for end in (local.first, local.second))
    return Separation(local.distance, turned(rotation, local.normal), *ends)


def segment_to_segment(
    a0: FloatArray, a1: FloatArray, b0: FloatArray, b1: FloatArray
) -> Separation:
    """Two segments given by their ends. The nearest points of two lines, moved into the segments
    one after the other."""
    u = a1 - a0
    v = b1 - b0
    w = a0 - b0
    uu = dot(u, u)
    vv = dot(v, v)
    uv = dot(u, v)
    uw = dot(u, w)
    vw = dot(v, w)
    uu1 = np.where(uu > 0, uu, 1.0)
    vv1 = np.where(vv > 0, vv, 1.0)
    area = uu * vv - uv * uv
    crossing = area > 1e-12 * uu * vv
    s = np.where(
        crossing, np.clip((uv * vw - vv * uw) / np.where(crossing, area, 1.0), 0.0, 1.0), 0.5
    )
    t = np.clip((uv * s + vw) / vv1, 0.0, 1.0)
    s = np.clip((uv * t - uw) / uu1, 0.0, 1.0)
    t = np.clip((uv * s + vw) / vv1, 0.0, 1.0)
    return between(
        a0 + u * s,
        b0 + v * t,
        lambda rows: _perpendicular(cross(taken(u, rows), taken(v, rows)), taken(u, rows)),
    )


def _perpendicular(vector: FloatArray, along: FloatArray) -> FloatArray:
    """Unit vectors of ``vector`` (3, n), or any unit vector perpendicular to ``along`` where it
    vanishes."""
    length = np.sqrt(dot(vector, vector))
    extent = np.sqrt(dot(along, along))
    other = cross(
        along,
        np.where(np.abs(along[0]) < 0.7 * extent, [[1.0], [0.0], [0.0]], [[0.0], [1.0], [0.0]]),
    )
    size = np.sqrt(dot(other, other))
    other = np.where(size > 0, other / np.where(size > 0, size, 1.0), _UP)
    good = length > 1e-9 * np.maximum(1e-300, dot(along, along))
    return np.where(good, vector / np.where(good, length, 1.0), other)


def nearest_on_triangle(point: FloatArray, corners: FloatArray) -> FloatArray:
    """Point (3, n) of each triangle (3, 3, n) nearest to each point."""
    way = following(corners) - corners
    arm = point[:, None] - corners
    squared = dot(way, way)
    share = np.clip(dot(arm, way) / np.where(squared > 0, squared, 1.0), 0.0, 1.0)
    on_edges = corners + way * share
    away = on_edges - point[:, None]
    nearest = dot(away, away).argmin(axis=0)
    normal = cross(way[:, 0], way[:, 1])
    squared = dot(normal, normal)
    inside = (squared > 0) & (dot(cross(way, arm), normal[:, None]) >= 0).all(axis=0)
    foot = point - normal * (dot(arm[:, 0], normal) / np.where(squared > 0, squared, 1.0))
    return np.where(inside, foot, on_edges[:, nearest, np.arange(len(nearest))])


def point_to_triangle(point: FloatArray, corners: FloatArray) -> Separation:
    """Points and triangles (3, 3, n)."""

    def inward(rows: IntArray) -> FloatArray:
        a, b, c = taken(corners, rows).transpose(1, 0, 2)
        return -_perpendicular(cross(b - a, c - a), b - a)

    return between(point, nearest_on_triangle(point, corners), inward)


def segment_to_triangle(start: FloatArray, end: FloatArray, corners: FloatArray) -> Separation:
    """Segments and triangles (3, 3, n). A segment through the triangle is as deep as the shortest
    way out: back over the triangle's plane, or sideways over one of its edges (the faces of the
    prism that is their Minkowski difference)."""
    number = np.arange(start.shape[1])
    a, after = corners, following(corners)
    ends = np.concatenate([start, end], axis=1)
    by_ends = between(ends, nearest_on_triangle(ends, np.tile(corners, 2)))
    by_edges = segment_to_segment(
        *(np.tile(tip, 3) for tip in (start, end)), *(tip.reshape(3, -1) for tip in (a, after))
    )
    every = joined([by_ends, by_edges])
    best = every.distance.reshape(5, -1).argmin(axis=0)
    nearest = chosen_of(every, best * len(number) + number)
    edge = after[:, 0] - a[:, 0]
    normal = _perpendicular(cross(edge, a[:, 2] - a[:, 0]), edge)
    h0 = dot(start - a[:, 0], normal)
    h1 = dot(end - a[:, 0], normal)
    span = h0 - h1
    crossing = start + (end - start) * (h0 / np.where(np.abs(span) > 0, span, 1.0))
    within = dot(cross(after - a, crossing[:, None] - a), normal[:, None]) > 0
    through = (h0 * h1 < 0) & within.all(axis=0)
    if not through.any():
        return nearest
    shorter_start = np.abs(h0) < np.abs(h1)
    depth = np.minimum(np.abs(h0), np.abs(h1))
    deep = np.where(shorter_start, start, end)
    # The normal points from the segment to the triangle, from which the short part has come.
    inward = normal * np.sign(np.where(shorter_start, h0, h1))
    inside = Separation(-depth, inward, deep, deep - inward * depth)
    side = by_edges.distance.reshape(3, -1).argmin(axis=0)
    over = chosen_of(by_edges, side * len(number) + number)
    sideways = Separation(-over.distance, -over.normal, over.first, over.second)
    inside = merged(inside, sideways, over.distance < depth)
    return merged(nearest, inside, through)


def merged(first: Separation, second: Separation, chosen: BoolArray) -> Separation:
    """``second`` in the pairs that are ``chosen`` (n,), ``first`` in the others."""
    return Separation(
        *(
            np.where(chosen, getattr(second, f.name), getattr(first, f.name))
            for f in fields(Separation)
        )
    )
