"""Where on a body something stands whose place is the body's origin."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from .hull import convex_hull
from .narrow.closed_forms import nearest_on_triangle
from .shapes import ConvexHull, Mesh, Shape


def nearest_to_origin(shape: Shape) -> FloatArray:
    """The origin (3,) of a shape's space [m], or, where that lies outside its bounding box, the
    nearest point of the surface; of a shape that is no mesh and no hull, of its box."""
    low, high = shape.local_bounds
    nearest = np.clip(0.0, low, high)
    if not nearest.any() or not isinstance(shape, ConvexHull | Mesh):
        return np.asarray(nearest)
    surface = shape if isinstance(shape, Mesh) else convex_hull(shape.points)
    if len(surface.triangles) == 0:
        return np.asarray(nearest)
    corners = surface.points[surface.triangles].transpose(2, 1, 0)
    found = nearest_on_triangle(np.zeros((3, corners.shape[-1])), corners)
    return np.asarray(found[:, (found**2).sum(axis=0).argmin()])
