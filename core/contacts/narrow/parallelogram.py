"""Where a parallelogram lies over the square |u|, |v| <= 1: area, centre and least height, many
pairs at a time.

Area and centre are integrals along an outline (Green's theorem). The outline of the parallelogram,
each of its points moved to the nearest one of the square, goes around every point inside the square
just as often as before: what it encloses is what both have in common. It is closed wherever edges
coincide or cross at next to no angle, and nothing has to be put in order.

Arrays have the pairs along their last axis; points are (u, v, height). Sums are in a fixed order,
so that results do not depend on which pairs are computed together.
"""

from __future__ import annotations

import numpy as np

from ...arrays import BoolArray, FloatArray
from .box_axes import EDGE_TOLERANCE

_SQUARE = np.array([-1.0, 1.0]).reshape(2, 1, 1, 1)
_BORDERS = (1.0 + EDGE_TOLERANCE) * _SQUARE[None].swapaxes(0, 1)

_LEAST = 1e-150
"""Added to divisors, so that none is 0: no quotient overflows in sizes of up to 1e50."""

_NOWHERE = 1e100
"""Least height where there is no overlap."""

_THIN = 5e-15
"""Area up to which the centre is the middle of the edges."""


def overlap(
    centre: FloatArray, sides: FloatArray, within: FloatArray, lowest: FloatArray | None = None
) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
    """The part of the square under the parallelogram ``centre + s sides[0] + t sides[1]``, |s|, |t|
    <= 1, of ``centre`` (3, p) and ``sides`` (2, 3, p), as far as its height is ``within`` (p,) of
    the least there: area (p,), centre (2, p), the ``lowest`` point (3, p), which may be known, and
    whether there is any (p,)."""
    sides = sides * np.copysign(1.0, sides[:, 2:])  # both ascend
    if lowest is None:
        lowest = _lowest(centre, sides)
    # Integrals about a point of the overlap, so that little is lost where it is small.
    integrals = _integrals(_outline(centre, sides, lowest[2] + within), lowest[:2])
    area = np.abs(integrals[0]) / 2
    middle = integrals[1:] / (3.0 * integrals[0] + _LEAST)
    middle += lowest[:2]
    found = lowest[2] < _NOWHERE
    thin = ((area <= _THIN) & found).nonzero()[0]
    if len(thin):
        middle[:, thin] = _middle_of_edges(centre.take(thin, axis=1), sides.take(thin, axis=2))
    return area, np.minimum(np.maximum(middle, -1.0), 1.0), lowest, found


def _edges(centre: FloatArray, sides: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Middles (2, 2, 3, p) of the edges along either side, and where these come into the square and
    leave it (2, 2, p), as parts of their halves; in the wrong order where they lie outside."""
    middles = np.empty((2, *sides.shape))
    np.subtract(centre, sides[::-1], out=middles[0])
    np.add(centre, sides[::-1], out=middles[1])
    borders = _BORDERS - middles[:, :, :2]
    borders *= 1.0 / (sides[:, :2] + _LEAST)
    enter = np.minimum(borders[0], borders[1])
    leave = np.maximum(borders[0], borders[1])
    enter = np.maximum(np.maximum(enter[:, :, 0], enter[:, :, 1]), -1.0)
    leave = np.minimum(np.minimum(leave[:, :, 0], leave[:, :, 1]), 1.0)
    return middles, np.minimum(enter, 2.0, out=enter), leave


def _lowest(centre: FloatArray, sides: FloatArray) -> FloatArray:
    """The lowest point (3, p) of the parallelogram over the square: where one of its edges, all of
    which ascend, comes in, or at the square's own lowest corner."""
    count = centre.shape[1]
    points = np.empty((5, 3, count))
    begins = points[:4].reshape(2, 2, 3, count)
    middles, enter, leave = _edges(centre, sides)
    np.multiply(sides, enter[:, :, None], out=begins)
    begins += middles
    np.copyto(begins[:, :, 2], _NOWHERE, where=enter > leave)
    rows, (a, b) = sides.reshape(6, -1), sides
    determinant = a[0] * b[1] - a[1] * b[0] + _LEAST
    across = a[1:] * b[2::-2] - a[2::-2] * b[1:]  # minus slope times determinant
    corner = np.copysign(1.0, across * determinant, out=points[4, :2])
    away = corner - centre[:2]
    # S and t times determinant.
    parts = np.abs(rows[4::-4] * away - rows[3:0:-2] * away[::-1]) <= np.abs(determinant)
    across *= away
    height = centre[2] - (across[0] + across[1]) / determinant
    points[4, 2] = np.where(parts[0] & parts[1], height, _NOWHERE)
    place = points[:, 2].argmin(axis=0) * (3 * count) + np.arange(3 * count).reshape(3, -1)
    return np.asarray(points.reshape(-1).take(place))


def _outline(centre: FloatArray, sides: FloatArray, top: FloatArray) -> FloatArray:
    """Corners (2, 6, p) of the part of the parallelogram up to the height ``top`` (p,), in turn
    from the lowest one back to it."""
    rise = sides[:, 2] + _LEAST
    lowest = centre - sides[0] - sides[1]
    left = top - lowest[2]
    along = np.minimum(left / rise, 2.0)
    across = (left - along * rise) / rise[::-1]
    across = np.minimum(np.maximum(across, 0.0), 2.0)
    corners = np.empty((6, 2, centre.shape[1]))
    corners[::5] = lowest[:2]
    np.add(lowest[:2], sides[:, :2] * along[:, None], out=corners[1::3])
    np.add(corners[1::3], sides[::-1, :2] * across[:, None], out=corners[2:4])
    return corners.transpose(1, 0, 2)


def _integrals(corners: FloatArray, origin: FloatArray) -> FloatArray:
    """Twice the area inside an outline (2, 6, p) and the square, and six times its moments about
    ``origin`` (2, p); all three (3, p) negative where the outline is clockwise."""
    count = corners.shape[2]
    begin = corners[:, :-1]
    way = corners[:, 1:] - corners[:, :-1]
    borders = _SQUARE - begin
    borders *= 1.0 / (way + _LEAST)
    (enter_u, enter_v), (leave_u, leave_v) = (
        np.minimum(borders[0], borders[1]),
        np.maximum(borders[0], borders[1]),
    )
    # Between these parts of each edge, in turn, what it is moved to is straight.
    parts = np.empty((5, 5, count))
    parts[:, 0] = 0.0
    np.minimum(enter_u, enter_v, out=parts[:, 1])
    np.maximum(leave_u, leave_v, out=parts[:, 4])
    later = np.maximum(enter_u, enter_v, out=enter_u)
    sooner = np.minimum(leave_u, leave_v, out=leave_u)
    np.minimum(later, sooner, out=parts[:, 2])
    np.maximum(later, sooner, out=parts[:, 3])
    np.maximum(parts, 0.0, out=parts)
    np.minimum(parts, 1.0, out=parts)
    points = np.empty((2, 26, count))
    moved = points[:, :25]
    inner = moved.reshape(2, 5, 5, count)
    np.multiply(parts, way[:, :, None], out=inner)
    inner += begin[:, :, None]
    np.maximum(moved, -1.0, out=moved)
    np.minimum(moved, 1.0, out=moved)
    moved -= origin[:, None]
    points[:, 25] = points[:, 0]
    x, y = points
    terms = np.empty((3, 25, count))
    np.multiply(x[:-1], y[1:], out=terms[0])
    terms[0] -= x[1:] * y[:-1]
    np.add(moved, points[:, 1:], out=terms[1:])
    terms[1:] *= terms[0]
    for half in (12, 6, 3):
        terms[:, :half] += terms[:, half : 2 * half]
    return terms[:, 0] + terms[:, 1] + terms[:, 2] + terms[:, 24]


def _middle_of_edges(centre: FloatArray, sides: FloatArray) -> FloatArray:
    """Middle (2, p) of the bounds of the edges of the parallelogram over the square."""
    middles, enter, leave = _edges(centre, sides)
    ends = np.array([enter, leave])[:, :, :, None] * sides[:, :2] + middles[:, :, :2]
    inside = (enter <= leave)[:, :, None]
    return np.asarray(
        (
            np.where(inside, ends, 1.0).min(axis=(0, 1, 2))
            + np.where(inside, ends, -1.0).max(axis=(0, 1, 2))
        )
        / 2
    )
