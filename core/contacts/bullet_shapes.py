"""Shapes as Blender hands them to Bullet, from the bounding box or the vertices of an object.

Boxes and round shapes have the size of the bounding box and are centred at the object's origin,
wherever the centre of that box is. All are built without scale; Bullet then scales each shape by
its own rules. The margin of boxes and cylinders lies inside, that of cones, hulls and meshes
outside; a hull is first moved inwards by 0.04 m unless it uses its own margin.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from .hull import Hull, convex_hull, shrunk_hull
from .shapes import Box, Capsule, Cone, ConvexHull, Cylinder, Mesh, Shape, Sphere, points_array

DEFAULT_MARGIN = 0.04
"""Bullet's margin in metres, for every shape whose own is not used."""


def shape_from_bounding_box(
    kind: str,
    bounds: ArrayLike,
    scale: Sequence[float] = (1.0, 1.0, 1.0),
    margin: float = DEFAULT_MARGIN,
) -> Shape:
    """BOX, SPHERE, CAPSULE, CYLINDER or CONE around an object.

    ``bounds`` (2, 3): lowest and highest corner in the object's space, or the eight corners of
    ``Object.bound_box``; ``scale`` of the object; ``margin`` of its rigid body. Raises ValueError
    for a scale that is not positive or a box without extent.
    """
    corners = points_array("bounds", bounds)
    x, y, z = (np.ptp(corners, axis=0) / 2).tolist()
    sx, sy, sz = _scale(scale)
    round_radius = max(x, y)
    match kind:
        case "BOX":
            return Box((2 * x * sx, 2 * y * sy, 2 * z * sz), rounding=margin)
        case "SPHERE":
            return Sphere(max(x, y, z) * sx)
        case "CAPSULE":
            return Capsule(round_radius * sy, max(0.0, 2 * (z - round_radius)) * sz)
        case "CYLINDER":
            return Cylinder(
                max(round_radius * sx, margin), max(2 * z * sz, 2 * margin), rounding=margin
            )
        case "CONE":
            return Cone(round_radius * sx, 2 * z * sz, margin)
    raise ValueError(f"kind: expected BOX, SPHERE, CAPSULE, CYLINDER or CONE, got {kind!r}")


def convex_hull_shape(
    points: ArrayLike,
    scale: Sequence[float] = (1.0, 1.0, 1.0),
    margin: float | None = None,
) -> ConvexHull:
    """CONVEX_HULL of an object's vertices (n, 3) in its own space, with its own ``margin`` or, for
    None, Bullet's. Raises ValueError for bad points or a scale that is not positive."""
    vertices = points_array("points", points)
    factor = np.array(_scale(scale))
    hull = convex_hull(vertices)
    if margin is not None:
        return ConvexHull(hull.points * factor, margin)
    inner = shrunk_hull(hull, DEFAULT_MARGIN)
    if inner is None:
        return ConvexHull(hull.points * factor)
    rounding = DEFAULT_MARGIN * float(np.min(factor))
    if np.ptp(factor) <= 1e-6 * np.max(factor):
        return ConvexHull(hull.points * factor, rounding=rounding)
    # Moved in before it is scaled and grown afterwards: under an uneven scale Bullet's hull is not
    # the object's.
    outer = shrunk_hull(Hull(inner.points * factor, inner.triangles), -rounding)
    return (
        ConvexHull(inner.points * factor, rounding)
        if outer is None
        else ConvexHull(outer.points, rounding=rounding)
    )


def mesh_shape(
    points: ArrayLike,
    triangles: ArrayLike,
    scale: Sequence[float] = (1.0, 1.0, 1.0),
    margin: float = DEFAULT_MARGIN,
) -> Mesh:
    """MESH of an object's vertices (n, 3) and triangles (t, 3) in its own space. Its margin, used
    or not, lies outside, except against spheres, which touch the triangles themselves. Raises
    ValueError for bad arrays or a scale that is not positive."""
    return Mesh(
        points_array("points", points) * np.array(_scale(scale)),
        np.asarray(triangles),
        margin,
        sphere_margin=0.0,
    )


def _scale(scale: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = (float(s) for s in scale)
    if not all(np.isfinite((x, y, z))) or min(x, y, z) <= 0:
        raise ValueError(f"scale: must be greater than 0, got {(x, y, z)}")
    return x, y, z
