"""Where a parallelogram lies over the square |u|, |v| <= 1: area, centre and least height, many pairs at a time.

The edges of the intersection need not be put in order: its area and centre are integrals along its boundary (Green's theorem), which
consists of the parts of either outline that lie inside the other. Arrays have the pairs along their last axis; points are (u, v, height).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...arrays import BoolArray, FloatArray
from .box_axes import EDGE_TOLERANCE

# Corners of the square in turn, and the way from each to the next, along its first or its second direction.
_START = np.array([[-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0]])[:, :, None]
_WAY = np.array([[2.0, 0.0, -2.0, 0.0], [0.0, 2.0, 0.0, -2.0]])[:, :, None]

_LEAST_DETERMINANT, _LEAST_STEP = 1e-100, 1e-150
"""What a vanishing area and a vanishing component of an edge count as: no quotient by them overflows in sizes of up to 1e50."""

_LEVEL = 1e-15
"""Rise along an edge below which it counts as level."""

_SOLID = 1e-14
"""Twice the area below which the centre is the mean of the edges."""

_OPEN = 1e-6
"""Distance between its two ends above which a boundary isn't closed."""

_WIDER, _MOST_TOLERANCE = 1.618, 1e-8
"""Factor by which the tolerance grows where a boundary isn't closed, of no simple ratio so that a second tie is unlikely, and its limit."""


class Overlap(NamedTuple):
    """Per pair: ``area``, centre ``u`` and ``v``, ``lowest`` height, and whether there is any overlap: ``found``."""

    area: FloatArray
    u: FloatArray
    v: FloatArray
    lowest: FloatArray
    found: BoolArray


class _Edges(NamedTuple):
    """Eight edges per pair: 0-3 those of the parallelogram, 4-7 those of the square. Rows of ``begin`` and ``way`` (5, 8, p): u, v, height,
    and the two coordinates that are within ``limit`` (2, 8, p) where the edge is inside the other outline."""

    begin: FloatArray
    way: FloatArray
    limit: FloatArray


def overlap(centre: FloatArray, first: FloatArray, second: FloatArray, within: FloatArray) -> Overlap:
    """The part of the square under the parallelogram ``centre + s first + t second``, |s|, |t| <= 1, each (3, p), as far as its height is
    ``within`` (p,) of the least there."""
    # Where one corner of the parallelogram alone is low enough, and over the square, the overlap is a triangle there.
    steps = within / np.maximum(np.abs(np.stack([first[2], second[2]])), 1e-12)
    low = np.where(np.stack([first[2], second[2]]) < 0, 1.0, -1.0)
    corner = centre + first * low[0] + second * low[1]
    leg_1, leg_2 = first * (low[0] * steps[0]), second * (low[1] * steps[1])
    span = np.abs(np.stack([corner, corner - leg_1, corner - leg_2])[:, :2])
    alone = (steps <= 2).all(axis=0) & (span <= 1).all(axis=(0, 1))
    area = np.abs(leg_1[0] * leg_2[1] - leg_1[1] * leg_2[0]) / 2
    u, v, _ = corner - (leg_1 + leg_2) / 3
    result = Overlap(area, u, v, corner[2], alone.copy())
    rest = np.flatnonzero(~alone)
    if len(rest):
        parts = _intersection(centre.take(rest, axis=1), first.take(rest, axis=1), second.take(rest, axis=1), within[rest])
        for whole, part in zip(result, parts, strict=True):
            whole[rest] = part
    return result


def _intersection(
    centre: FloatArray, first: FloatArray, second: FloatArray, within: FloatArray, tolerance: float = EDGE_TOLERANCE
) -> Overlap:
    """`overlap` by way of the boundary; edges that are nearer to each other than ``tolerance`` coincide."""
    edges = _edges(centre, first, second, tolerance)
    t0, t1 = _inside(edges)
    used = t1 > t0
    begin, way = edges.begin[:3], edges.way[:3]
    z, dz = begin[2], way[2]
    heights = np.where(dz < 0, t1, t0)
    heights *= dz
    heights += z
    np.copyto(heights, np.inf, where=~used)
    lowest = heights.min(axis=0)
    found = np.asarray(used.any(axis=0))
    # Leave out what is higher; the cut closes the outline from where it goes out to where it comes in.
    top = np.where(found, lowest, 0.0) + within
    at = (top - z) / np.where(np.abs(dz) < _LEVEL, _LEVEL, dz)
    used &= (np.abs(dz) > _LEVEL) | (z <= top)
    leaves, enters = used & (dz > _LEVEL) & (at < t1), used & (dz < -_LEVEL) & (at > t0)
    np.copyto(t1, at, where=leaves)
    np.copyto(t0, at, where=enters)
    used &= t1 > t0
    leaves &= used
    enters &= used
    start, end = t0 * way[:2], t1 * way[:2]
    start += begin[:2]
    end += begin[:2]
    area, u, v, open_by = _area_and_centre(start, end, used, leaves, enters)
    result = Overlap(area, u, v, lowest, found)
    # Where two edges are apart by the tolerance, to the last bit, neither may count, or both.
    wrong = np.flatnonzero(open_by > _OPEN) if tolerance < _MOST_TOLERANCE else ()
    if len(wrong):
        parts = _intersection(centre[:, wrong], first[:, wrong], second[:, wrong], within[wrong], _WIDER * tolerance)
        for whole, part in zip(result, parts, strict=True):
            whole[wrong] = part
    return result


def _edges(centre: FloatArray, first: FloatArray, second: FloatArray, tolerance: float) -> _Edges:
    """The edges of both outlines, counter-clockwise."""
    determinant = first[0] * second[1] - first[1] * second[0]
    second = second * np.where(determinant < 0, -1.0, 1.0)
    (cu, cv, cz), (e1u, e1v, e1z), (e2u, e2v, e2z) = centre, first, second
    count = len(cu)
    inverse = 1.0 / np.maximum(np.abs(determinant), _LEAST_DETERMINANT)
    begin, way = np.empty((5, 8, count)), np.empty((5, 8, count))
    back, ahead = centre - first, centre + first
    for number, corner in enumerate((back - second, ahead - second, ahead + second, back + second)):
        begin[:3, number] = corner
    np.multiply(first, 2.0, out=way[:3, 0])
    np.multiply(second, 2.0, out=way[:3, 1])
    np.negative(way[:3, :2], out=way[:3, 2:4])
    begin[3:, :4], way[3:, :4] = begin[:2, :4], way[:2, :4]
    begin[:2, 4:], way[:2, 4:] = _START, _WAY
    # Those of the square in the coordinates (s, t) of the parallelogram.
    du, dv = _START[0] - cu, _START[1] - cv
    f1, f2, g1, g2 = e2v * inverse, e2u * inverse, e1u * inverse, e1v * inverse
    np.subtract(du * f1, dv * f2, out=begin[3, 4:])
    np.subtract(dv * g1, du * g2, out=begin[4, 4:])
    np.subtract(_WAY[0] * f1, _WAY[1] * f2, out=way[3, 4:])
    np.subtract(_WAY[1] * g1, _WAY[0] * g2, out=way[4, 4:])
    begin[2, 4:] = cz + begin[3, 4:] * e1z + begin[4, 4:] * e2z
    way[2, 4:] = way[3, 4:] * e1z + way[4, 4:] * e2z
    # Outlines that coincide count once: the one of the parallelogram. Both are moved by the same length, so that edges that cross at
    # next to no angle change over at one place.
    limit = np.empty((2, 8, count))
    limit[:, :4] = 1.0 + tolerance
    limit[0, 4:] = 1.0 - tolerance * np.hypot(f1, f2)
    limit[1, 4:] = 1.0 - tolerance * np.hypot(g1, g2)
    return _Edges(begin, way, limit)


def _inside(edges: _Edges) -> tuple[FloatArray, FloatArray]:
    """Where each edge comes into the other outline and where it leaves it (8, p), as parts of its length; in the wrong order where it lies
    outside."""
    begin, step = edges.begin[3:], edges.way[3:]
    np.copyto(step, _LEAST_STEP, where=np.abs(step) < _LEAST_STEP)
    low, high = -edges.limit, edges.limit
    low -= begin
    low /= step
    high -= begin
    high /= step
    # In the memory of what is no longer needed.
    t0 = np.minimum(low, high, out=step).max(axis=0)
    t1 = np.maximum(low, high, out=high).min(axis=0)
    return np.maximum(t0, 0.0, out=t0), np.minimum(t1, 1.0, out=t1)


def _area_and_centre(
    start: FloatArray, end: FloatArray, used: BoolArray, leaves: BoolArray, enters: BoolArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Area and centre (u, v) inside the boundary pieces that are ``used`` (8, p), from ``start`` to ``end`` (2, 8, p), which are lost, with
    a straight line from the one that ``leaves`` to the one that ``enters``; and by how much the boundary is open."""
    weight = used.astype(np.float64)
    number = np.maximum(weight.sum(axis=0), 1.0)
    # About a point of the outline, so that little is lost where it is small.
    origin = np.einsum("ikp,kp->ip", start, weight) / number
    start -= origin[:, None]
    end -= origin[:, None]
    cross = start[0] * end[1]
    cross -= start[1] * end[0]
    cross *= weight
    out, back = np.einsum("ikp,kp->ip", end, leaves), np.einsum("ikp,kp->ip", start, enters)
    closing = out[0] * back[1] - out[1] * back[0]
    total = cross.sum(axis=0) + closing
    open_by = np.abs(np.einsum("ikp,kp->ip", end - start, weight) + back - out).max(axis=0)
    both = np.add(start, end, out=start)
    centre = np.einsum("ikp,kp->ip", both, cross) + (out + back) * closing
    solid = total > _SOLID
    centre /= 3.0 * np.where(solid, total, 1.0)
    thin = np.flatnonzero(~solid)
    if len(thin):
        centre[:, thin] = np.einsum("ikp,kp->ip", both[..., thin], weight[:, thin]) / (2 * number[thin])
    u, v = np.clip(centre + origin, -1.0, 1.0)
    return np.maximum(total, 0.0) / 2, u, v, open_by
