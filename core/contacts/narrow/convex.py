"""Signed distances between convex cores, one pair at a time by FCL (GJK) where they are apart and
by EPA where they overlap."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ...frozen import frozen
from ..hull import Hull, convex_hull
from .closed_forms import Separation
from .cores import Core, CoreTable, Kind, Size
from .frames import SIDES
from .penetration import Farthest, penetration, row_dots

_POINT_RADIUS = 1e-9
"""Radius [m] of the spheres and capsules that stand for points and segments, which FCL lacks."""

_CONFIRMED = 2e-5
"""Difference of the upper and the lower bound on a distance up to which the upper one is accepted
[m]."""

_TOUCHING = 1e-7
"""Metres of distance below which the nearest points do not determine the normal."""

_GROWTH = 1.5
"""A body is grown by this multiple of an uncertain distance, so that it overlaps the other one."""

_SOME_PLANES = 64

_MOST_TRIANGLES = 100_000

_ALIKE = 1e-6
"""Metres of depth by which points differ that count as equally deep: those of a face whose
coordinates are rounded to single precision."""

BOX_CORNERS = np.array([[x, y, z] for x in (1.0, -1.0) for y in (1.0, -1.0) for z in (1.0, -1.0)])
"""The corners (8, 3) of a box of half extents 1."""


@frozen
class Convex:
    """A convex body for queries, around its own origin: the hull of ``points`` (n, 3), or of discs
    across the z axis around them with ``radii`` (n,), if it is no polytope; ``hull``: that of
    points if it is known; ``half`` (3,): half extents of a box. ``first`` and ``second``: FCL's
    objects for the first body of a pair, which stays where it is, and for the second."""

    first: Any
    second: Any
    points: FloatArray
    radii: FloatArray | None = None
    hull: Hull | None = None
    half: FloatArray | None = None

    @property
    def curved(self) -> bool:
        """Whether it is not a polytope."""
        return self.radii is not None

    def farthest(self, directions: FloatArray) -> FloatArray:
        """The points (..., 3) farthest along unit ``directions`` (..., 3)."""
        heights = directions @ self.points.T
        if self.radii is None:
            return np.asarray(self.points[heights.argmax(axis=-1)])
        length = np.hypot(directions[..., 0], directions[..., 1])[..., None]
        best = (heights + length * self.radii).argmax(axis=-1)
        result = self.points.take(best, axis=0)
        radius = self.radii[best][..., None] / np.maximum(length, 1e-300)
        result[..., :2] += directions[..., :2] * radius
        return np.asarray(result)

    def support(self, directions: FloatArray) -> FloatArray:
        """Greatest heights (m,) of the body along unit ``directions`` (m, 3)."""
        return row_dots(directions, self.farthest(directions))

    def some_planes(self) -> tuple[FloatArray, FloatArray]:
        """Unit normals (f, 3) and offsets (f,) of some half-spaces that contain the body."""
        normals = SIDES
        if self.hull is not None:
            faces = self.hull.planes()[0]
            normals = np.concatenate([normals, faces[:: -(-len(faces) // _SOME_PLANES) or 1]])
        return normals, self.support(normals)

    def corners(self, direction: FloatArray) -> FloatArray:
        """The points (n, 3), of each disc those that are farthest along a direction (3,) and
        opposite to it."""
        if self.radii is None:
            return self.points
        across = direction * [1.0, 1.0, 0.0]
        out = np.outer(self.radii, across / max(float(np.linalg.norm(across)), 1e-300))
        return np.concatenate([self.points + out, self.points - out])

    def placed(self, rotation: FloatArray, offset: FloatArray) -> Farthest:
        """The body at a pose."""
        if self.curved:
            return lambda ways: self.farthest(ways @ rotation) @ rotation.T + offset
        points = self.points @ rotation.T + offset
        columns = points.T
        return lambda ways: points[(ways @ columns).argmax(axis=-1)]


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
    """The body of a core; of a mesh, that of its hull."""
    import fcl

    if core.mesh is not None:
        return _polytope(convex_hull(core.mesh.points[np.unique(core.mesh.triangles)]))
    if core.hull is not None:
        return _polytope(core.hull)
    x, y, z = half = core.half[size]
    radii: FloatArray | None = None
    match core.kind:
        case Kind.CYLINDER | Kind.CONE:
            points = np.array([[0.0, 0.0, z], [0.0, 0.0, -z]])
            radii = np.array([x if core.kind is Kind.CYLINDER else 0.0, x])
        case _:
            points = BOX_CORNERS * half
    geometry: Any
    box = None
    match core.kind:
        case Kind.POINT:
            geometry = fcl.Sphere(_POINT_RADIUS)
        case Kind.SEGMENT:
            geometry = fcl.Capsule(_POINT_RADIUS, 2 * z)
        case Kind.BOX:
            geometry = fcl.Box(2 * x, 2 * y, 2 * z)
            box = half
        case Kind.CYLINDER:
            geometry = fcl.Cylinder(x, 2 * z)
        case Kind.CONE:
            geometry = fcl.Cone(x, 2 * z)
    objects = fcl.CollisionObject(geometry), fcl.CollisionObject(geometry)
    return Convex(*objects, points, radii, half=box)


def _polytope(hull: Hull) -> Convex:
    import fcl

    faces = np.concatenate([np.full((len(hull.triangles), 1), 3), hull.triangles], axis=1).ravel()
    geometry = fcl.Convex(hull.points, len(hull.triangles), faces)
    return Convex(
        fcl.CollisionObject(geometry),
        fcl.CollisionObject(geometry),
        hull.points,
        hull=hull,
    )


def separations(
    first: Sequence[Convex],
    second: Sequence[Convex],
    rotation: FloatArray,
    offset: FloatArray,
    depths: bool = True,
) -> Separation:
    """Separations of pairs of bodies, in the frames of the first ones.

    Args:
        first: first bodies (n,), which stay where they are.
        second: second bodies (n,).
        rotation: of the second bodies (3, 3, n).
        offset: of the second bodies (3, n) [m].
        depths: False: bodies that overlap have distance 0, which takes less time.
    """
    import fcl

    request = fcl.DistanceRequest(enable_nearest_points=True)
    rotation = np.ascontiguousarray(rotation.transpose(2, 0, 1))
    offset = np.ascontiguousarray(offset.T)
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
        for k in (~apart).nonzero()[0].tolist():
            distance[k], normal[k], nearest[k] = _overlap(
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
            # Occasionally FCL's nearest points are millimetres too far apart: the first body is
            # grown until the two overlap.
            distance[k], normal[k], nearest[k] = _overlap(
                first[k], second[k], rotation[k], offset[k], _GROWTH * distance[k]
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


def _overlap(
    a: Convex, b: Convex, rotation: FloatArray, offset: FloatArray, growth: float = 0.0
) -> tuple[float, FloatArray, FloatArray]:
    """Signed distance (negative) [m], unit normal from first to second, and deepest points (2, 3)
    of two bodies that overlap.

    Args:
        a: the first body, which stays where it is.
        b: the second body.
        rotation: of the second (3, 3).
        offset: of the second (3,) [m].
        growth: by which the first is grown [m]; makes bodies overlap that hardly do.
    """
    if a.half is not None and not growth:
        corners = b.placed(rotation, offset)(-SIDES) if b.curved else b.points @ rotation.T + offset
        beneath = _beneath_face(a.half, corners)
        if beneath is not None:
            return beneath
    first = (lambda way: a.farthest(way) + growth * way) if growth else a.farthest
    found = penetration(first, b.placed(rotation, offset))
    half = found.normal * (found.depth / 2)
    deepest = np.array([found.middle + half - growth * found.normal, found.middle - half])
    return growth - found.depth, found.normal, deepest


def _beneath_face(
    half: FloatArray, points: FloatArray
) -> tuple[float, FloatArray, FloatArray] | None:
    """What `_overlap` returns for a box with these ``half`` extents (3,) at the origin, where a
    face of it is surely the nearest way out; otherwise None.

    ``points`` (n, 3): of the other body, those farthest against each of the `SIDES` among them. To
    leave along a normal, the body has to move by the depth of its deepest point beneath that side.
    If even the deepest point beneath the nearest side is farther from all others, there is no
    nearer way out. Of several such points in the box, the middle counts.
    """
    reach = np.concatenate([half, half])
    depth = reach - np.concatenate([points.min(axis=0), -points.max(axis=0)])
    side = int(depth.argmin())
    normal, least = SIDES[side], float(depth[side])
    beneath = reach[side] - points @ normal
    room = reach - SIDES @ points[beneath.argmax()]
    room[side] = np.inf
    if least <= 0 or room.min() <= least:
        return None
    alike = points[(beneath >= least - _ALIKE) & (np.abs(points) <= half).all(axis=1)]
    place = alike.sum(axis=0) / len(alike)
    place[side % 3] = normal[side % 3] * (reach[side] - least)
    return -least, normal, np.array([place + least * normal, place])
