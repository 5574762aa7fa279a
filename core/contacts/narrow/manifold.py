"""Contact patches: where the facing features of two touching cores lie on each other, many pairs at
a time.

Each core contributes its supporting feature: a face of a box, hull or triangle, the end of a
cylinder, a line along the side of a round core. Both are projected onto the contact plane and
intersected, as far as the gap between them is within ``ROUGHNESS`` of the least. A face on a face
gives their common area, an edge a strip along it, a corner almost nothing: centre and area change
smoothly as a body tips.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import BoolArray, FloatArray
from ...frozen import frozen
from .frames import added, cross, dot, following, smooth_step, turned

ROUGHNESS = 0.01
"""Metres beyond the least gap up to which two surfaces belong to the patch: as uneven as floors,
crates and the edges of stones are. So the patch of a body of 1 m hardly moves if that tips by
1e-3 rad."""

TOGETHER = 4e-5
"""Metres beyond the least distance of two cores up to which points and lines of them belong to
their patch."""

_FACE_AREA = 1e-3
"""Area [m^2] from about which on faces of two cores belong to their patch within ``ROUGHNESS``."""

UNEVEN = 0.001
"""Metres by which a face of a mesh or hull may be uneven."""

_LYING, _TIPPED = 0.002, 0.02
"""Slopes between two faces below which they lie on each other, and above which they touch along a
line or at a point."""

_EDGE_ON = 3e-9
"""Area of a polygon over the square of its extent up to which it is seen edge-on."""

_LINE_GAP = 0.00005
"""Largest gap within a patch of faces that touch along a line or at a point [m]."""


_SMALL = 1 << 10
"""Elements of an array up to which calls take longer than what they compute."""


@frozen
class Patches:
    """Per pair: ``centre`` (3, n) in the contact plane through the origin, ``area`` (n,) [m^2],
    ``found`` (n,) False where the features do not face each other, ``gap`` (n,) by which the
    nearest corner of the patch is further apart than the distance along the normal (infinite where
    there is none), ``corners`` (3, k, n) of the patch, which of them are ``used`` (k, n), ``wide``
    (n,) False for a line, and ``reach`` (n,): the largest gap within the patch beyond the least."""

    centre: FloatArray
    area: FloatArray
    found: BoolArray
    gap: FloatArray
    corners: FloatArray
    used: BoolArray
    wide: BoolArray
    reach: FloatArray


def patch_gap(slope: FloatArray, parallel: float = ROUGHNESS) -> FloatArray:
    """Largest gap [m] within a patch of faces at a ``slope`` (rise over run): ``parallel`` where
    they are parallel, smoothly less where they are tipped, so that the patch stays near the line or
    point where they touch."""
    tipped = smooth_step((slope - _LYING) / (_TIPPED - _LYING))
    return parallel - (parallel - _LINE_GAP) * tipped


def within_of(area: FloatArray) -> FloatArray:
    """Metres beyond the least distance of two cores up to which patches of an ``area`` (n,) [m^2]
    belong to theirs."""
    return TOGETHER + ROUGHNESS * (area / (area + _FACE_AREA))


def most_within(radius: FloatArray) -> FloatArray:
    """The largest distance [m] beyond the least one of two cores at which a triangle within a
    circle of ``radius`` (n,) [m] can belong to their patch."""
    return np.maximum(within_of(np.pi * radius**2), np.minimum(2 * _TIPPED * radius, ROUGHNESS))


def contact_plane(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors (3, n) that make a right-handed frame with each unit normal."""
    # Duff et al. 2017, "Building an orthonormal basis, revisited".
    x, y, z = normal
    sign = np.where(z < 0, -1.0, 1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    return np.array([1.0 + sign * x * x * a, sign * b, -sign * x]), np.array(
        [b, sign + y * y * a, -y]
    )


def patches(
    first: FloatArray, second: FloatArray, normal: FloatArray, gap: float = ROUGHNESS
) -> Patches:
    """Patches of features given as convex polygons ``first`` (3, k, n) and ``second`` (3, m, n)
    around any origin, in either sense, repeated corners allowed; ``normal`` (3, n) from first to
    second; ``gap``: the largest within patches of parallel faces [m].

    The area and its centre are integrals along the boundary of the intersection (Green's theorem),
    which consists of the parts of each polygon's edges that lie inside everything else and need not
    be put in order.
    """
    u, v = contact_plane(normal)
    frame = np.array([u, v, normal])
    (a, slope_a, level_a, low_a, high_a), (b, slope_b, level_b, low_b, high_b) = for_both(
        _projected, (first, frame), (second, frame)
    )
    # The gap between the two as a linear function over the plane, counted from the least that their
    # farthest corners would leave.
    slope = slope_b - slope_a
    level = (level_b - low_b[2]) + (high_a[2] - level_a)
    origin = (np.maximum(low_a, low_b)[:2] + np.minimum(high_a, high_b)[:2]) / 2
    level = level + dot(slope, origin)
    bounds = np.array([low_a, high_a, low_b, high_b])[:, :2]
    slack = 1e-9 * np.abs(bounds - origin).max(axis=(0, 1))
    # Boundary of the first inside the second, and of the second strictly inside the first: a shared
    # edge counts once.
    (a, after_a, lines_a, edge_on_a), (b, after_b, lines_b, edge_on_b) = for_both(
        _outline, (a[:2], origin, -slack), (b[:2], origin, slack)
    )
    pieces = for_both(_clipped, (a, after_a, lines_b), (b, after_b, lines_a))
    start, end = (np.concatenate([piece[k] for piece in pieces], axis=1) for k in range(2))
    used = np.concatenate([piece[2] for piece in pieces])
    # Leave out where the gap is larger; the cut closes the outline from where it goes out to where
    # it comes in.
    from_gap, to_gap = (level + dot(ends, slope[:, None]) for ends in (start, end))
    least_gap = np.where(used, np.minimum(from_gap, to_gap), np.inf).min(axis=0)
    reach = patch_gap(np.sqrt(dot(slope, slope)), gap)
    top = np.where(np.isinf(least_gap), 0.0, least_gap) + reach
    rise = to_gap - from_gap
    leaves = used & (from_gap <= top) & (to_gap > top)
    enters = used & (from_gap > top) & (to_gap <= top)
    share = np.divide(top - from_gap, rise, out=np.zeros_like(rise), where=leaves | enters)
    used &= (from_gap <= top) | (to_gap <= top)
    cut = start + (end - start) * share
    start = np.where(enters, cut, start)
    end = np.where(leaves, cut, end)
    area, centre = _area_and_centre(start, end, used, leaves, enters)
    # The half-planes of a polygon seen edge-on enclose a strip without end.
    found = used.any(axis=0) & (area > 0) & ~edge_on_a & ~edge_on_b
    centre = np.where(found, centre + origin, 0.0)
    corners = start + origin[:, None]
    return Patches(
        centre=u * centre[0] + v * centre[1],
        area=np.where(found, area, 0.0),
        found=found,
        gap=np.where(found, np.maximum(least_gap, 0.0), np.inf),
        corners=u[:, None] * corners[0] + v[:, None] * corners[1],
        used=used & found,
        wide=found,
        reach=reach,
    )


def for_both(
    make: Callable[..., tuple[Any, ...]], a: tuple[NDArray[Any], ...], b: tuple[NDArray[Any], ...]
) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """What ``make`` returns for the arguments ``a`` and for ``b``, arrays with the pairs along the
    last axis: in one call where these have the same shapes and are small."""
    if any(one.shape != other.shape or one.size > _SMALL for one, other in zip(a, b, strict=True)):
        return make(*a), make(*b)
    count = a[0].shape[-1]
    both = make(*(np.concatenate(one, axis=-1) for one in zip(a, b, strict=True)))
    return tuple(v[..., :count] for v in both), tuple(v[..., count:] for v in both)


def _projected(polygon: FloatArray, frame: FloatArray) -> tuple[FloatArray, ...]:
    """Polygons (3, k, n) in a ``frame`` (3, 3, n) with the contact plane, their planes there as of
    `_plane`, and their lowest and highest coordinates (3, n)."""
    placed = turned(frame, polygon)
    return placed, *_plane(placed), placed.min(axis=1), placed.max(axis=1)


def _outline(
    polygon: FloatArray, origin: FloatArray, outwards: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
    """Corners (2, k, n) of polygons about an ``origin`` (2, n), counter-clockwise; the next ones;
    the `_lines` of their edges, so far ``outwards`` (n,); and `_edge_on`."""
    corners = _counter_clockwise(polygon - origin[:, None])
    after = following(corners)
    return corners, after, _lines(corners, after, outwards), _edge_on(corners)


def _area_and_centre(
    start: FloatArray, end: FloatArray, used: BoolArray, leaves: BoolArray, enters: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Area (n,) and centre (2, n) inside the boundary pieces that are ``used`` (k, n), from
    ``start`` to ``end`` (2, k, n), with a straight line from the one that ``leaves`` to the one
    that ``enters``."""
    out = added(end * leaves)
    back = added(start * enters)
    closing = out[0] * back[1] - out[1] * back[0]
    turns = np.where(used, start[0] * end[1] - start[1] * end[0], 0.0)
    area = (added(turns) + closing) / 2
    moment = (added((start + end) * turns) + (out + back) * closing) / 6
    # Cancellation can move the centre of a sliver far away: clip it to the corners' bounds.
    least = np.where(used, np.minimum(start, end), np.inf).min(axis=1)
    most = np.where(used, np.maximum(start, end), -np.inf).max(axis=1)
    return area, np.clip(moment / np.where(used.any(axis=0) & (area > 0), area, 1.0), least, most)


def _plane(polygon: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Slope (2, n) and value at the origin (n,) of the plane z(x, y) of each polygon (3, k, n)."""
    rays = polygon[:, 1:] - polygon[:, :1]
    normal = added(cross(rays[:, :-1], rays[:, 1:]))
    steep = 1e-6 * np.sqrt(dot(normal, normal)) + 1e-300
    upright = np.where(np.abs(normal[2]) > steep, normal[2], np.copysign(steep, normal[2]))
    slope = -normal[:2] / upright
    return slope, polygon[2, 0] - dot(slope, polygon[:2, 0])


def _edge_on(polygon: FloatArray) -> BoolArray:
    """Which polygons (2, k, n) have hardly any area for their extent."""
    rays = polygon[:, 1:] - polygon[:, :1]
    area = np.abs(added(rays[0, :-1] * rays[1, 1:] - rays[1, :-1] * rays[0, 1:]))
    return np.asarray(area <= _EDGE_ON * dot(rays, rays).max(axis=0))


def _counter_clockwise(polygon: FloatArray) -> FloatArray:
    """Polygons (2, k, n), those that run clockwise reversed."""
    after = following(polygon)
    area = added(polygon[0] * after[1] - polygon[1] * after[0])
    return np.where(area < 0, polygon[:, ::-1], polygon)


def _lines(polygon: FloatArray, after: FloatArray, outwards: FloatArray) -> FloatArray:
    """The edges of polygons, each from a corner to the one ``after`` it, as half-planes (3, k, n)
    that reach so far ``outwards`` (n,) [m]: ``l[0] x + l[1] y + l[2] >= 0`` inside, in metres. One
    without length holds everywhere."""
    way = after - polygon
    length = np.sqrt(dot(way, way))
    real = length > 0
    across = np.array([-way[1], way[0]]) / np.where(real, length, 1.0)
    return np.concatenate([across, np.where(real, -dot(across, polygon), 1e30)[None] + outwards])


def _clipped(
    start: FloatArray, end: FloatArray, lines: FloatArray
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """The part of each edge (2, k, n) of polygons, from a corner to the next, that satisfies all
    lines (3, m, n), and whether there is one (k, n)."""
    f0 = start[0, :, None] * lines[0]
    f0 += start[1, :, None] * lines[1]
    f0 += lines[2]
    f1 = np.concatenate([f0[1:], f0[:1]])
    out0 = f0 < 0
    out1 = np.concatenate([out0[1:], out0[:1]])
    crossing = out0 != out1
    t = np.divide(f0, f0 - f1, out=np.zeros_like(f0), where=crossing)
    begin = np.where(out0 & crossing, t, 0.0).max(axis=1)
    finish = np.where(out1 & crossing, t, 1.0).min(axis=1)
    used = (begin < finish) & ~(out0 & out1).any(axis=1)
    way = end - start
    used &= (way != 0).any(axis=0)
    return start + way * begin, start + way * finish, used
