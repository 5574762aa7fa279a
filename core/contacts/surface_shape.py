"""The shape of a surface that is seen: its convex hull where that is hardly different, otherwise
its triangles, as a solid or a shell."""

from __future__ import annotations

from enum import Enum

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..frozen import frozen
from .hull import Hull, convex_hull
from .shapes import ConvexHull, Mesh, Shape

SUNK_IN = 0.05
"""Depth beneath the surface of a solid down to which bodies inside it touch it [m]."""

_SAME_PLACE = 1e-6
"""Distance up to which two vertices count as one, relative to the extent of the mesh: at a seam,
meshes have two vertices in one place."""

_FEW, _MOST = 500_000, 20_000_000
"""Corners times planes of the hull that are compared first, to find most concave meshes, and above
which a mesh isn't compared wholly."""


_SMOOTH = 0.01
"""Part of a body's middle extent up to which its hull may stand for its surface."""


class Surface(Enum):
    """What of an object touches others."""

    SEEN = "seen"
    """Its surface: a solid if that is closed and its faces look outwards, else a shell."""
    SOLID = "solid"
    SHELL = "shell"
    CONVEX_HULL = "convex_hull"


@frozen
class SurfaceShape:
    """A shape, and how far the convex hull is from the surface [m], a lower bound where that has
    very many triangles; ``limbs`` as in `Body`."""

    shape: Shape
    deviation: float = 0.0
    limbs: tuple[float, ...] = ()


def surface_shape(
    points: FloatArray,
    triangles: IntArray,
    surface: Surface,
    tolerance: float,
) -> SurfaceShape:
    """The shape of a mesh, without triangles that of the hull of its points. Raises ValueError
    where there is none.

    Args:
        points: (n, 3) [m].
        triangles: (t, 3) over them.
        surface: what of the mesh touches others.
        tolerance: deviation up to which the hull stands for a closed surface [m].
    """
    hulled = ConvexHull(points)
    tolerance = min(tolerance, _SMOOTH * float(np.median(np.ptp(points, axis=0))))
    if len(triangles) == 0:
        return SurfaceShape(hulled)
    hull = convex_hull(hulled.points)
    corners = points[triangles]
    deviation = _deviation(hull, corners, _FEW)
    convex = deviation <= tolerance and corners.size // 3 * len(hull.planes()[0]) <= _MOST
    if convex:
        deviation = _deviation(hull, corners, _MOST)
        convex = deviation <= tolerance
    if surface is Surface.CONVEX_HULL:
        return SurfaceShape(hulled, deviation)
    volume = float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])))
    closed = surface is not Surface.SHELL and is_closed(points, triangles)
    solid = surface is Surface.SOLID or (closed and volume > 0)
    flat = surface is Surface.SEEN and not closed and _covers(hull, corners)
    if convex and ((solid and closed) or flat):
        return SurfaceShape(hulled if flat else ConvexHull(points, sunk_in=SUNK_IN), deviation)
    outwards = triangles[:, ::-1] if solid and volume < 0 else triangles
    return SurfaceShape(Mesh(points, outwards, sunk_in=SUNK_IN if solid else 0.0), deviation)


def is_closed(points: FloatArray, triangles: IntArray) -> bool:
    """Whether every edge of a triangle belongs to exactly one other, which runs through it in the
    other direction."""
    size = float(np.ptp(points, axis=0).max())
    _, place = np.unique(
        np.round(points / max(_SAME_PLACE * size, 1e-300)), axis=0, return_inverse=True
    )
    merged = place.reshape(-1)[triangles]
    merged = merged[(merged != np.roll(merged, 1, axis=1)).all(axis=1)]
    start = merged.reshape(-1)
    end = np.roll(merged, -1, axis=1).reshape(-1)
    count = len(points)
    ways = np.sort(start * count + end)
    back = np.sort(end * count + start)
    return len(ways) > 0 and bool((ways[1:] != ways[:-1]).all()) and np.array_equal(ways, back)


def hull_deviation(points: FloatArray, triangles: IntArray, smooth: float = 0.0) -> float:
    """How far the convex hull of ``points`` (n, 3), with the tolerance ``smooth`` [m], is from
    ``triangles`` (t, 3) over them [m]; of very many, from some."""
    if len(triangles) == 0:
        return 0.0
    return _deviation(convex_hull(points, smooth), points[triangles], _FEW)


def _deviation(hull: Hull, corners: FloatArray, most: int) -> float:
    """How far triangles (t, 3, 3) are beneath the hull of their points [m]: each, the farthest of
    its corners from that plane of the hull to which it is nearest. Of as many as have at most
    ``most`` corners times planes."""
    normals, offsets = hull.planes()
    if len(normals) == 0:
        return 0.0
    corners = corners[:: max(1, corners.size // 3 * len(normals) // most)]
    step = max(1, _FEW // (3 * len(normals)))
    parts = (corners[k : k + step] for k in range(0, len(corners), step))
    return max(
        0.0, *(float((offsets - part @ normals.T).max(axis=1).min(axis=1).max()) for part in parts)
    )


def _covers(hull: Hull, corners: FloatArray) -> BoolArray | bool:
    """Whether triangles (t, 3, 3) in one plane leave no part of their flat hull uncovered."""
    normals, _ = hull.planes()
    if len(normals) > 2:
        return False
    faces = hull.points[hull.triangles]
    ours, whole = (
        np.linalg.norm(np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]), axis=1).sum()
        for c in (corners, faces)
    )
    return bool(2 * ours >= whole * (1 - 1e-6))  # a flat hull has both sides
