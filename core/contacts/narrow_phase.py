"""Narrow phase: signed distance and contact patch of pairs of shapes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .hull import convex_hull, hull_2d
from .shapes import Box, Capsule, Cone, ConvexHull, Cylinder, Mesh, Part, Shape, Sphere, parts_of, transformed_bounds

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Patch:
    """What two bodies have between them: signed ``distance`` [m], ``normal`` from first to second, the ``points`` (k, 3) of the patch in
    the middle between the surfaces [m, world] and the ``area`` of their hull in the contact plane [m^2]."""

    distance: float
    normal: FloatArray
    points: FloatArray
    area: float


class NarrowPhase:
    """Queries between bodies given by index. Collision objects are made once per body."""

    def __init__(self, shapes: Sequence[Shape]) -> None:
        self._parts = [parts_of(shape) for shape in shapes]
        self._objects: list[list[Any] | None] = [None] * len(self._parts)

    def patch(self, first: int, second: int, a: FloatArray, b: FloatArray, tolerance: float) -> Patch | None:
        """The patch of two bodies under world matrices ``a`` and ``b`` (4, 4), or None where they are more than ``tolerance`` apart."""
        found = []
        for part_a, object_a in self._placed(first, a, 0):
            for part_b, object_b in self._placed(second, b, 1):
                patch = _part_patch(part_a, object_a, part_b, object_b, tolerance)
                if patch is not None:
                    found.append(patch)
        if not found:
            return None
        nearest = min(found, key=lambda p: p.distance)
        if len(found) == 1:
            return nearest
        points = np.concatenate([p.points for p in found])
        return Patch(nearest.distance, nearest.normal, points, patch_area(points, nearest.normal))

    def _placed(self, body: int, matrix: FloatArray, side: int) -> list[tuple[Part, Any]]:
        import fcl

        made = self._objects[body]
        if made is None:
            made = [fcl.CollisionObject(_geometry(part.shape)) for part in self._parts[body]]
            self._objects[body] = made
        for part, item in zip(self._parts[body], made, strict=True):
            world = matrix @ part.matrix
            item.setRotation(np.ascontiguousarray(world[:3, :3]))
            item.setTranslation(np.ascontiguousarray(world[:3, 3]))
        return list(zip(self._parts[body], made, strict=True))


def _geometry(shape: Shape) -> Any:
    import fcl

    match shape:
        case Box(size=(x, y, z)):
            return fcl.Box(x, y, z)
        case Sphere(radius=radius):
            return fcl.Sphere(radius)
        case Capsule(radius=radius, height=height):
            return fcl.Capsule(radius, height)
        case Cylinder(radius=radius, height=height):
            return fcl.Cylinder(radius, height)
        case Cone(radius=radius, height=height):
            return fcl.Cone(radius, height)
        case ConvexHull(points=points):
            hull = convex_hull(points)
            faces = np.concatenate([np.full((len(hull.triangles), 1), 3), hull.triangles], axis=1).ravel()
            return fcl.Convex(hull.points, len(hull.triangles), faces)
        case Mesh(points=points, triangles=triangles):
            model = fcl.BVHModel()
            model.beginModel(len(triangles), len(points))
            model.addSubModel(points, triangles)
            model.endModel()
            return model
    raise TypeError(f"no geometry for {shape!r}")


def _part_patch(part_a: Part, object_a: Any, part_b: Part, object_b: Any, tolerance: float) -> Patch | None:
    import fcl

    margin = part_a.radius + part_b.radius
    result = fcl.DistanceResult()
    distance = fcl.distance(object_a, object_b, fcl.DistanceRequest(True, True), result)
    if distance > 0:
        if distance - margin > tolerance:
            return None
        start, end = (np.asarray(p, dtype=np.float64) for p in result.nearest_points)
        normal = (end - start) / np.linalg.norm(end - start)
        middle = (start + normal * part_a.radius + end - normal * part_b.radius) / 2
        return Patch(float(distance - margin), normal, middle[None], 0.0)
    contacts = fcl.CollisionResult()
    fcl.collide(object_a, object_b, fcl.CollisionRequest(num_max_contacts=32, enable_contact=True), contacts)
    if not contacts.contacts:
        return None
    deepest = max(contacts.contacts, key=lambda c: float(c.penetration_depth))
    normal = np.asarray(deepest.normal, dtype=np.float64)
    points = np.array([c.pos for c in contacts.contacts], dtype=np.float64)
    return Patch(-float(deepest.penetration_depth) - margin, normal, points, patch_area(points, normal))


def patch_area(points: FloatArray, normal: FloatArray) -> float:
    """Area in square metres of the convex hull of ``points`` (k, 3) seen along ``normal``."""
    if len(points) < 3:
        return 0.0
    u = np.cross(normal, [1.0, 0.0, 0.0] if abs(normal[0]) < 0.7 else [0.0, 1.0, 0.0])
    u /= np.linalg.norm(u)
    flat = np.stack([points @ u, points @ np.cross(normal, u)], axis=1)
    x, y = flat[hull_2d(flat)].T
    return float(abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2)


def world_bounds(shapes: Sequence[Shape], transforms: FloatArray) -> FloatArray:
    """Bounding boxes (n, 2, 3) of shapes under rigid ``transforms`` (n, 4, 4), margins included."""
    local = np.array([shape.local_bounds() for shape in shapes], dtype=np.float64).reshape(-1, 2, 3)
    return transformed_bounds(local, transforms)
