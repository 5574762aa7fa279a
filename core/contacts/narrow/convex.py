"""Signed distances between convex cores, one pair at a time: by FCL (GJK) where they are apart, by
EPA where they overlap."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ..hull import Hull
from ..motion import rotations
from .closed_forms import Separation
from .cores import Core, CoreTable, Kind, Size
from .penetration import Farthest, penetration, row_dots

_POINT_RADIUS = 1e-9
"""Radius [m] of the spheres and capsules that stand for points and segments, which FCL lacks."""

_CONFIRMED = 2e-5
"""Metres between the bounds on a distance below which it is accepted."""

_TOUCHING = 1e-7
"""Metres of distance below which the nearest points do not determine the normal."""

_GROWTH = 1.5
"""Times an uncertain distance by which a body is grown, so that it overlaps the other one."""

_MOST_TRIANGLES = 100_000

_TURNS = (
    None,
    *rotations(np.array([[1.0, -2.0, 0.7], [0.4, 0.9, -2.2], [-1.3, 0.3, 1.9]])).transpose(2, 0, 1),
)
"""Rotations under which a query is repeated."""

_UPRIGHT = np.eye(3)


@dataclass(frozen=True, slots=True)
class Convex:
    """A convex body for queries, around its own origin. ``first`` and ``second``: FCL's objects for
    the first body of a pair, which stays where it is, and for the second. ``farthest``: its points
    (m, 3) farthest along unit directions (m, 3). ``curved``: not a polytope."""

    first: Any
    second: Any
    farthest: Farthest
    curved: bool

    def support(self, directions: FloatArray) -> FloatArray:
        """Greatest heights (m,) of the body along unit ``directions`` (m, 3)."""
        return row_dots(directions, self.farthest(directions))


class ConvexDistances:
    """The bodies of a table's cores, and of single triangles of its meshes, made on first use."""

    def __init__(self, table: CoreTable) -> None:
        self._table = table
        # By the id of the core and the size: equal bodies share theirs.
        self._cores: dict[tuple[int, int], Convex] = {}
        self._triangles: dict[tuple[int, int], Convex] = {}

    def core(self, number: int, size: int) -> Convex:
        """The body of a core in one of its sizes."""
        core = self._table.cores[number]
        made = self._cores.get((id(core), size))
        if made is None:
            made = self._cores[id(core), size] = convex_of(core, size)
        return made

    def triangle(self, core: int, number: int, corners: FloatArray) -> Convex:
        """The body of triangle ``number`` of the mesh ``core``, with its ``corners`` (3, 3)."""
        made = self._triangles.get((core, number))
        if made is None:
            if len(self._triangles) >= _MOST_TRIANGLES:
                self._triangles.clear()
            made = self._triangles[core, number] = _polytope(
                Hull(corners, np.array([[0, 1, 2], [0, 2, 1]]))
            )
        return made


def convex_of(core: Core, size: int = Size.USUAL) -> Convex:
    """The body of a core that is not a mesh."""
    import fcl

    if core.kind is Kind.HULL:
        assert core.hull is not None
        return _polytope(core.hull)
    half = core.half[size]
    made, farthest = _MADE[core.kind]
    geometry = made(fcl, *(2 * half).tolist())
    curved = core.kind in (Kind.CYLINDER, Kind.CONE)
    return Convex(
        fcl.CollisionObject(geometry),
        fcl.CollisionObject(geometry),
        partial(farthest, half),
        curved,
    )


def _polytope(hull: Hull) -> Convex:
    import fcl

    faces = np.concatenate([np.full((len(hull.triangles), 1), 3), hull.triangles], axis=1).ravel()
    geometry = fcl.Convex(hull.points, len(hull.triangles), faces)
    return Convex(
        fcl.CollisionObject(geometry),
        fcl.CollisionObject(geometry),
        partial(_farthest_of_points, hull.points),
        False,
    )


def _farthest_of_box(half: FloatArray, directions: FloatArray) -> FloatArray:
    return np.where(directions < 0, -half, half)


def _farthest_of_cylinder(half: FloatArray, directions: FloatArray) -> FloatArray:
    points = _farthest_of_box(half, directions)
    points[:, :2] = _on_circle(half[0], directions)
    return points


def _farthest_of_cone(half: FloatArray, directions: FloatArray) -> FloatArray:
    points = np.empty_like(directions)
    points[:, :2] = _on_circle(half[0], directions)
    points[:, 2] = -half[2]
    tip = np.array([0.0, 0.0, half[2]])
    return np.where((directions @ tip >= row_dots(directions, points))[:, None], tip, points)


def _on_circle(radius: float, directions: FloatArray) -> FloatArray:
    """The points (m, 2) of a circle around the z axis farthest along directions (m, 3)."""
    length = np.hypot(directions[:, 0], directions[:, 1])
    return np.asarray(directions[:, :2] * (radius / np.where(length > 0, length, 1.0))[:, None])


def _farthest_of_points(points: FloatArray, directions: FloatArray) -> FloatArray:
    return np.asarray(points[(directions @ points.T).argmax(axis=1)])


_MADE: dict[
    Kind,
    tuple[
        Callable[[Any, float, float, float], Any], Callable[[FloatArray, FloatArray], FloatArray]
    ],
] = {
    Kind.POINT: (lambda fcl, x, y, z: fcl.Sphere(_POINT_RADIUS), _farthest_of_box),
    Kind.SEGMENT: (lambda fcl, x, y, z: fcl.Capsule(_POINT_RADIUS, z), _farthest_of_box),
    Kind.BOX: (lambda fcl, x, y, z: fcl.Box(x, y, z), _farthest_of_box),
    Kind.CYLINDER: (lambda fcl, x, y, z: fcl.Cylinder(x / 2, z), _farthest_of_cylinder),
    Kind.CONE: (lambda fcl, x, y, z: fcl.Cone(x / 2, z), _farthest_of_cone),
}
"""By kind: how FCL's geometry is made from the extents of a core, and the points farthest along
directions from its half extents."""


def separations(
    first: Sequence[Convex],
    second: Sequence[Convex],
    rotation: FloatArray,
    offset: FloatArray,
    depths: bool = True,
) -> Separation:
    """Separations of pairs of bodies in the frame of the first, the second placed by ``rotation``
    (3, 3, n) and ``offset`` (3, n). Without ``depths``, bodies that overlap have distance 0."""
    import fcl

    request = fcl.DistanceRequest(enable_nearest_points=True)
    rotation, offset = (
        np.ascontiguousarray(rotation.transpose(2, 0, 1)),
        np.ascontiguousarray(offset.T),
    )
    count = len(first)
    distance = np.empty(count)
    nearest = np.empty((count, 2, 3))
    for k, (a, b, turn, shift) in enumerate(zip(first, second, rotation, offset, strict=True)):
        moved = b.second
        moved.setRotation(turn)
        moved.setTranslation(shift)
        result = fcl.DistanceResult()
        distance[k] = fcl.distance(a.first, moved, request, result)
        nearest[k] = result.nearest_points
    apart = distance > _TOUCHING
    normal = (nearest[:, 1] - nearest[:, 0]) / np.where(apart, distance, 1.0)[:, None]
    if depths:
        for k in np.flatnonzero(~apart).tolist():
            distance[k], normal[k], nearest[k] = _overlapping(
                first[k], second[k], rotation[k], offset[k]
            )
    else:
        distance[~apart] = 0.0
    curved = np.flatnonzero(
        apart
        & np.array(
            [a.curved or b.curved for a, b in zip(first, second, strict=True)], dtype=np.bool_
        )
    )
    if len(curved):
        # The nearest points bound the distance from above, the supporting planes perpendicular to
        # their line from below.
        way = normal[curved]
        back = -np.einsum("nji,nj->ni", rotation[curved], way)
        between = (way * offset[curved]).sum(axis=1)
        between -= _supports([first[k] for k in curved.tolist()], way) + _supports(
            [second[k] for k in curved.tolist()], back
        )
        length = np.sqrt(((nearest[curved, 1] - nearest[curved, 0]) ** 2).sum(axis=1))
        distance[curved] = length
        normal[curved] = (nearest[curved, 1] - nearest[curved, 0]) / np.where(
            length > 0, length, 1.0
        )[:, None]
        for k in curved[length - between > _CONFIRMED].tolist():
            distance[k], normal[k], nearest[k] = _confirmed(
                first[k], second[k], rotation[k], offset[k], nearest[k]
            )
    return Separation(distance, normal.T.copy(), nearest[:, 0].T.copy(), nearest[:, 1].T.copy())


def _supports(bodies: Sequence[Convex], directions: FloatArray) -> FloatArray:
    """Support values (n,) of bodies, each along its own direction (n, 3)."""
    rows: dict[int, list[int]] = {}
    for row, body in enumerate(bodies):
        rows.setdefault(id(body), []).append(row)
    heights = np.empty(len(bodies))
    for chosen in rows.values():
        heights[chosen] = bodies[chosen[0]].support(directions[chosen])
    return heights


def _confirmed(
    a: Convex, b: Convex, rotation: FloatArray, offset: FloatArray, nearest: FloatArray
) -> tuple[float, FloatArray, FloatArray]:
    """Distance, normal and nearest points (2, 3) of two bodies that are apart, one of them curved.

    Occasionally FCL's nearest points are millimetres further apart than the supporting planes
    perpendicular to their line. The query is then repeated with both bodies rotated until the two
    bounds agree; where they never do, the first body is grown until the two overlap.
    """
    import fcl

    best = (np.inf, 0.0, nearest[0], nearest)
    for turn in _TURNS:
        if turn is not None:
            a.first.setRotation(turn)
            b.second.setRotation(turn @ rotation)
            b.second.setTranslation(turn @ offset)
            result = fcl.DistanceResult()
            fcl.distance(a.first, b.second, fcl.DistanceRequest(enable_nearest_points=True), result)
            nearest = np.array(result.nearest_points) @ turn
        distance = float(np.linalg.norm(nearest[1] - nearest[0]))
        if distance <= _TOUCHING:
            continue
        normal = (nearest[1] - nearest[0]) / distance
        way = normal[None]
        between = normal @ offset - a.support(way)[0] - b.support(-way @ rotation)[0]
        if distance - between < best[0]:
            best = (distance - between, distance, normal, nearest)
        if best[0] <= _CONFIRMED:
            break
    a.first.setRotation(_UPRIGHT)
    if best[0] <= _CONFIRMED:
        return best[1:]
    growth = _GROWTH * best[1]
    grown = Convex(None, None, lambda ways: a.farthest(ways) + growth * ways, True)
    distance, normal, nearest = _overlapping(grown, b, rotation, offset)
    return distance + growth, normal, nearest - np.stack([growth * normal, np.zeros(3)])


def _overlapping(
    a: Convex, b: Convex, rotation: FloatArray, offset: FloatArray
) -> tuple[float, FloatArray, FloatArray]:
    """Signed distance, normal and deepest points (2, 3) of two bodies that overlap."""
    found = penetration(a.farthest, lambda ways: b.farthest(ways @ rotation) @ rotation.T + offset)
    half = found.normal * (found.depth / 2)
    return -found.depth, found.normal, np.stack([found.middle + half, found.middle - half])
