"""Sizes of bodies that waves spread in: those of the bounding box, and the wall of a hollow
body."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray, IntArray
from .hull import convex_hull
from .shapes import ConvexHull, Mesh, Shape

Edges = tuple[float, float, float]

SHEET = 0.01
"""Thickness [m] of a sheet modelled as one surface."""


class Size(NamedTuple):
    """The ``edges`` of a body [m], in descending order, the last of them the thickness of its wall,
    and its ``volume`` [m^3]."""

    edges: Edges
    volume: float

    @classmethod
    def of_box(cls, edges: Edges) -> Size:
        """That of a box."""
        large, middle, small = sorted(edges, reverse=True)
        return cls((large, middle, small), large * middle * small)


def size_of(shape: Shape) -> Size:
    """The size of a body of this shape."""
    x, y, z = np.ptp(shape.local_bounds, axis=0).tolist()
    match shape:
        case Mesh():
            return walled((x, y, z), shape.points, shape.triangles)
        case ConvexHull():
            hull = convex_hull(shape.points)
            return walled((x, y, z), hull.points, hull.triangles)
    return Size.of_box((x, y, z))


def walled(box: Edges, points: FloatArray, triangles: IntArray) -> Size:
    """The size of a body with a bounding ``box``, whose surface are ``triangles`` (t, 3) over
    ``points`` (n, 3) [m]; its wall by volume and area of a closed mesh, at most `SHEET` of one with
    open edges."""
    if len(triangles) == 0:
        return Size.of_box(box)
    large, middle, small = sorted(box, reverse=True)
    a, b, c = points[triangles].transpose(1, 0, 2)
    across = np.cross(b - a, c - a)
    edges = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1).reshape(-1, 2))
    _, faces = np.unique(edges[:, 0] * len(points) + edges[:, 1], return_counts=True)
    area = float(np.linalg.norm(across, axis=1).sum() / 2)
    if (faces == 2).all():
        volume = abs(float(np.einsum("ij,ij->", a, across) / 6))
        return Size((large, middle, wall_of((large, middle, small), volume, area)), volume)
    wall = min(small or SHEET, SHEET)
    return Size((large, middle, wall), area * wall)


def wall_of(size: Edges, volume: float, area: float) -> float:
    """The thickness [m] of the wall of a closed body with the sizes of its bounding box, the
    greatest first, from its volume [m³] and the area of its surface, inside and outside [m²].

    It is 2 volume / area of a thin wall. A solid box has ``area / (2 volume) = 1/a + 1/b + 1/c``,
    and solid cylinders and balls have the same: without the terms of the other two sizes, c is
    left.
    """
    large, middle, small = size
    if min(volume, middle) <= 0:
        return small
    rest = area / (2 * volume) - 1 / large - 1 / middle
    return min(small, 1 / rest) if rest > 0 else small
