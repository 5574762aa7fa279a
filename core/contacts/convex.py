"""Distances between convex cores by FCL (GJK), one pair at a time, and how deep they overlap."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .closed_forms import Separation
from .cores import Core, CoreTable, Kind
from .hull import Hull
from .motion import rotations

FloatArray = NDArray[np.float64]

_POINT_RADIUS = 1e-9
"""FCL has no points and segments: spheres and capsules of that radius in metres stand in."""

_CONFIRMED = 2e-5
"""Metres by which bounds on a distance may differ."""

_TOUCHING = 1e-7
"""Metres of distance below which nearest points say nothing about the normal."""

_STARTS = 3
_MOST_STEPS = 8
_MOST_AXES = 64
_MOST_TRIANGLES = 100_000


def _ways(count: int) -> FloatArray:
    """Directions over half a sphere."""
    k = np.arange(count) + 0.5
    z = k / count
    angle = np.pi * (1 + 5**0.5) * k
    ring = np.sqrt(1 - z * z)
    return np.stack([ring * np.cos(angle), ring * np.sin(angle), z], axis=1)


_ALL_WAYS = _ways(40)

_TURNS = (None, *rotations(np.array([[1.0, -2.0, 0.7], [0.4, 0.9, -2.2], [-1.3, 0.3, 1.9]])).transpose(2, 0, 1))
"""Ways to turn a question round."""


class Size(Enum):
    """Which of its sizes a box is taken in."""

    CORE = "core"
    SHARP = "sharp"
    THICK = "thick"


@dataclass(frozen=True, slots=True)
class Convex:
    """A convex body for queries, around its own origin. ``item``: FCL's object. ``axes`` (k, 3): unit directions square to its faces, each
    in one sense. ``support``: the greatest height of the body along unit directions (m, 3). ``curved``: not a polytope."""

    item: Any
    axes: FloatArray
    support: Callable[[FloatArray], FloatArray]
    curved: bool

    def place(self, rotation: FloatArray, centre: FloatArray) -> None:
        self.item.setRotation(rotation)
        self.item.setTranslation(centre)


class ConvexDistances:
    """The bodies of a table's cores, and of single triangles of its meshes, made on first use."""

    def __init__(self, table: CoreTable) -> None:
        self._table = table
        self._cores: dict[tuple[int, Size], Convex] = {}
        self._triangles: dict[tuple[int, int], Convex] = {}

    def core(self, number: int, size: Size = Size.CORE) -> Convex:
        """Of a core. ``size`` chooses among those of a box."""
        made = self._cores.get((number, size))
        if made is None:
            made = self._cores[number, size] = convex_of(self._table.cores[number], size)
        return made

    def triangle(self, core: int, number: int, corners: FloatArray) -> Convex:
        """Of triangle ``number`` of the mesh ``core``, with its ``corners`` (3, 3)."""
        made = self._triangles.get((core, number))
        if made is None:
            if len(self._triangles) >= _MOST_TRIANGLES:
                self._triangles.clear()
            made = self._triangles[core, number] = _polytope(Hull(corners, np.array([[0, 1, 2], [0, 2, 1]])))
        return made


def convex_of(core: Core, size: Size = Size.CORE) -> Convex:
    """The body of a core that is not a mesh."""
    import fcl

    if core.kind is Kind.HULL:
        assert core.hull is not None
        return _polytope(core.hull)
    half = {Size.CORE: core.half, Size.SHARP: core.sharp_half, Size.THICK: core.thick_half}[size]
    x, _, z = (2 * half).tolist()
    geometry = {
        Kind.POINT: lambda: fcl.Sphere(_POINT_RADIUS),
        Kind.SEGMENT: lambda: fcl.Capsule(_POINT_RADIUS, z),
        Kind.BOX: lambda: fcl.Box(*(2 * half).tolist()),
        Kind.CYLINDER: lambda: fcl.Cylinder(x / 2, z),
        Kind.CONE: lambda: fcl.Cone(x / 2, z),
    }[core.kind]()
    axes = np.eye(3) if core.kind is Kind.BOX else np.eye(3)[2:]
    curved = core.kind in (Kind.CYLINDER, Kind.CONE)
    return Convex(fcl.CollisionObject(geometry), axes, partial(_SUPPORT[core.kind], half), curved)


def _polytope(hull: Hull) -> Convex:
    import fcl

    faces = np.concatenate([np.full((len(hull.triangles), 1), 3), hull.triangles], axis=1).ravel()
    item = fcl.CollisionObject(fcl.Convex(hull.points, len(hull.triangles), faces))
    normals, _ = hull.planes()
    return Convex(item, normals[:_MOST_AXES], partial(_support_of_points, hull.points), False)


def _support_of_box(half: FloatArray, directions: FloatArray) -> FloatArray:
    return np.asarray(np.abs(directions) @ half)


def _support_of_cylinder(half: FloatArray, directions: FloatArray) -> FloatArray:
    return np.asarray(np.hypot(directions[:, 0], directions[:, 1]) * half[0] + np.abs(directions[:, 2]) * half[2])


def _support_of_cone(half: FloatArray, directions: FloatArray) -> FloatArray:
    rim = np.hypot(directions[:, 0], directions[:, 1]) * half[0] - directions[:, 2] * half[2]
    return np.asarray(np.maximum(directions[:, 2] * half[2], rim))


def _support_of_points(points: FloatArray, directions: FloatArray) -> FloatArray:
    return np.asarray((directions @ points.T).max(axis=1))


_SUPPORT: dict[Kind, Callable[[FloatArray, FloatArray], FloatArray]] = {
    Kind.POINT: _support_of_box,
    Kind.SEGMENT: _support_of_box,
    Kind.BOX: _support_of_box,
    Kind.CYLINDER: _support_of_cylinder,
    Kind.CONE: _support_of_cone,
}


def separations(
    objects: Sequence[tuple[Convex, Convex]], rotation_a: FloatArray, centre_a: FloatArray, rotation_b: FloatArray, centre_b: FloatArray
) -> Separation:
    """Between pairs of objects, placed in the world by rotations (n, 3, 3) and centres (n, 3)."""
    import fcl

    request = fcl.DistanceRequest(enable_nearest_points=True)
    count = len(objects)
    distance = np.empty(count)
    normal = np.empty((count, 3))
    nearest = np.empty((count, 2, 3))
    for k, (a, b) in enumerate(objects):
        a.place(rotation_a[k], centre_a[k])
        b.place(rotation_b[k], centre_b[k])
        result = fcl.DistanceResult()
        distance[k] = fcl.distance(a.item, b.item, request, result)
        if distance[k] > _TOUCHING:
            nearest[k] = result.nearest_points
            normal[k] = (nearest[k, 1] - nearest[k, 0]) / distance[k]
            if a.curved or b.curved:
                distance[k], normal[k], nearest[k] = _confirmed(
                    a, b, (rotation_a[k], centre_a[k]), (rotation_b[k], centre_b[k]), nearest[k]
                )
        else:
            distance[k], normal[k], nearest[k] = _penetration(a, b, rotation_a[k], centre_a[k], rotation_b[k], centre_b[k])
    return Separation(distance, normal, nearest[:, 0].copy(), nearest[:, 1].copy())


_Placed = tuple[FloatArray, FloatArray]


def _confirmed(a: Convex, b: Convex, place_a: _Placed, place_b: _Placed, nearest: FloatArray) -> tuple[float, FloatArray, FloatArray]:
    """Distance, normal and nearest points (2, 3) of two that are apart, of which one is curved.

    Between the points that FCL found lies no less than the distance; between the supporting planes square to their line, no more. Now and
    then the two differ by millimetres: then FCL is asked again with everything turned, until they agree.
    """
    import fcl

    (rotation_a, centre_a), (rotation_b, centre_b) = place_a, place_b
    best = (np.inf, 0.0, nearest[0], nearest)
    for turn in _TURNS:
        if turn is not None:
            a.place(turn @ rotation_a, turn @ centre_a)
            b.place(turn @ rotation_b, turn @ centre_b)
            result = fcl.DistanceResult()
            fcl.distance(a.item, b.item, fcl.DistanceRequest(enable_nearest_points=True), result)
            nearest = np.array(result.nearest_points) @ turn
        distance = float(np.linalg.norm(nearest[1] - nearest[0]))
        if distance <= _TOUCHING:
            continue
        normal = (nearest[1] - nearest[0]) / distance
        way = normal[None]
        between = normal @ (centre_b - centre_a) - a.support(way @ rotation_a)[0] - b.support(-way @ rotation_b)[0]
        if distance - between < best[0]:
            best = (distance - between, distance, normal, nearest)
        if best[0] <= _CONFIRMED:
            break
    return best[1:]


def _penetration(
    a: Convex, b: Convex, rotation_a: FloatArray, centre_a: FloatArray, rotation_b: FloatArray, centre_b: FloatArray
) -> tuple[float, FloatArray, FloatArray]:
    """Signed distance, normal and nearest points (2, 3) of two that overlap: the least way to move the second out.

    The overlap along any direction is what their supports say. From the best of many directions, those of their faces, axes and centres and
    what FCL's own penetration depth suggests among them, the second is moved clear; the nearest points then show a better direction, until
    there is none. (FCL's depth is mostly right, but off by any amount where two just touch.)
    """
    import fcl

    towards = centre_b - centre_a
    length = float(np.linalg.norm(towards))
    result = fcl.DistanceResult()
    fcl.distance(a.item, b.item, fcl.DistanceRequest(enable_nearest_points=True, enable_signed_distance=True), result)
    suggested = np.subtract(*result.nearest_points)
    size = float(np.linalg.norm(suggested))
    directions = np.concatenate(
        [
            a.axes @ rotation_a.T,
            b.axes @ rotation_b.T,
            towards[None] / length if length > 1e-9 else np.zeros((0, 3)),
            suggested[None] / size if np.isfinite(size) and size > 1e-9 else np.zeros((0, 3)),
            _ALL_WAYS,
        ]
    )
    directions = np.concatenate([directions, -directions])

    def overlap(ways: FloatArray) -> FloatArray:
        return a.support(ways @ rotation_a) + ways @ centre_a + b.support(-ways @ rotation_b) - ways @ centre_b

    overlaps = overlap(directions)
    request = fcl.DistanceRequest(enable_nearest_points=True)
    depth, normal, nearest = np.inf, directions[0], np.stack([centre_a, centre_b])
    for start in np.argsort(overlaps, kind="stable")[:_STARTS].tolist():
        here, way = float(overlaps[start]), directions[start]
        for _ in range(_MOST_STEPS):
            if here < depth:
                depth, normal = here, way
            shift = way * (here + max(1e-3, 0.2 * here))
            b.item.setTranslation(centre_b + shift)
            result = fcl.DistanceResult()
            apart = float(fcl.distance(a.item, b.item, request, result))
            if apart <= _TOUCHING:
                break
            points = np.array(result.nearest_points, dtype=np.float64)
            if here <= depth:
                nearest = points - np.stack([np.zeros(3), shift])
            way = (points[1] - points[0]) / apart
            less = float(overlap(way[None])[0])
            if less >= here - 1e-9:
                break
            here = less
    middle = nearest.mean(axis=0)
    return -depth, normal, np.stack([middle + normal * depth / 2, middle - normal * depth / 2])
