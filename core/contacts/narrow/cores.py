"""Shapes reduced to cores, the primitives of the narrow phase.

Every primitive is a core (a point, a segment, a box, a cylinder, a cone, a hull, a triangle) and
all points within ``radius`` of it: a sphere is a point, a capsule a segment, a box with rounded
edges a smaller box. Distances are between cores, less the two radii.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from enum import IntEnum

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray
from ...frozen import frozen
from ..hull import Hull, convex_hull, shrunk_hull
from ..shapes import (
    Box,
    Capsule,
    Compound,
    Cone,
    ConvexHull,
    Cylinder,
    Mesh,
    Primitive,
    Shape,
    Sphere,
    parts_of,
    places_of,
)
from .manifold import contact_plane

_SQUARE = 1e-6
"""Tolerance, relative to its size, with which a hull counts as a box."""


class Kind(IntEnum):
    """Kinds of cores, simple ones first."""

    POINT = 0
    SEGMENT = 1
    BOX = 2
    CYLINDER = 3
    CONE = 4
    HULL = 5
    MESH = 6


class Size(IntEnum):
    """The three sizes that a core may have, by what it meets. They differ only for a box with
    rounded edges, see `Box.rounding`: a smaller box grown by the rounding."""

    USUAL = 0
    SHARP = 1  # where two boxes meet
    THICK = 2  # where a box meets a mesh


@frozen
class Core:
    """One primitive. ``matrix`` (4, 4): from core to shape. By `Size`: ``half`` (3, 3), of a box
    its half extents, of a round core (radius, radius, half height), of a segment (0, 0, half
    length); and the ``radius`` (3,) by which it is grown. ``outline`` (3,) half extents of its
    flat faces. ``is_box``: authored as a box. ``hull``: of a HULL, moved inwards by its rounding;
    ``sharp_hull``: before that, with the full extent of its flat faces. ``mesh_radius_to_points``:
    the radius of a mesh against spheres. ``sunk_in``: how far beneath its surface bodies touch it
    [m]."""

    kind: Kind
    matrix: FloatArray
    radius: Sequence[float]
    half: FloatArray
    outline: FloatArray
    is_box: bool = False
    hull: Hull | None = None
    sharp_hull: Hull | None = None
    mesh: Mesh | None = None
    mesh_radius_to_points: float = 0.0
    sunk_in: float = np.inf

    def bounds(self) -> FloatArray:
        """(2, 3) lowest and highest corner of the core in its own frame."""
        if self.mesh is not None:
            return self.mesh.core_bounds()
        if self.hull is not None:
            return np.array([self.hull.points.min(axis=0), self.hull.points.max(axis=0)])
        half = self.half.max(axis=0)
        return np.array([-half, half])

    def thickness(self) -> float:
        """Smallest extent [m]: of a shell that of its surface, of a solid mesh that of its bounds,
        of a hull the smallest width square to a face."""
        if self.mesh is not None:
            inside = float(np.ptp(self.bounds(), axis=0).min()) if self.mesh.sunk_in > 0 else 0.0
            return inside + 2 * min(self.radius[0], self.mesh_radius_to_points)
        if self.hull is not None:
            normals, _ = self.hull.planes()
            return (
                float(np.ptp(self.hull.points @ normals.T, axis=0).min(initial=np.inf))
                + 2 * self.radius[0]
            )
        return 2 * (float(self.half[0].min()) + self.radius[0])


def _simple(kind: Kind, part: Primitive, half: Sequence[float], rounding: float = 0.0) -> Core:
    size = np.array(half, dtype=np.float64)
    inner = np.maximum(size - rounding, 0.0) if rounding else size
    return Core(kind, part.matrix, 3 * [part.radius + rounding], np.tile(inner, (3, 1)), size)


def _core(part: Primitive, solid: bool) -> Core:
    """The core of a part. ``solid``: a mesh counts as the volume of its convex hull."""
    match part.shape:
        case Sphere(radius=radius):
            return _simple(Kind.POINT, replace(part, radius=part.radius + radius), (0, 0, 0))
        case Capsule(radius=radius, height=height):
            return _simple(
                Kind.SEGMENT, replace(part, radius=part.radius + radius), (0, 0, height / 2)
            )
        case Box(size=size, rounding=rounding):
            return _box(part.matrix, part.radius, np.array(size) / 2, rounding)
        case Cylinder(radius=radius, height=height, rounding=rounding):
            # A core without height or radius has no inside: keep a thousandth of them.
            limited = min(rounding, 0.999 * radius, 0.999 * height / 2)
            return _simple(Kind.CYLINDER, part, (radius, radius, height / 2), limited)
        case Cone(radius=radius, height=height):
            return _simple(Kind.CONE, part, (radius, radius, height / 2))
        case ConvexHull(points=points, rounding=rounding, sunk_in=sunk_in):
            core = _hull(part, points, rounding)
            return core if sunk_in is None else replace(core, sunk_in=sunk_in)
        case Mesh() as mesh:
            if solid:
                return _hull(part, mesh.points[np.unique(mesh.triangles)], 0.0)
            to_points = (
                part.radius
                if mesh.sphere_margin is None
                else part.radius - mesh.margin + mesh.sphere_margin
            )
            return replace(
                _simple(Kind.MESH, part, (0, 0, 0)),
                mesh=mesh,
                mesh_radius_to_points=to_points,
                sunk_in=mesh.sunk_in,
            )
    raise TypeError(f"no core for {part.shape!r}")


def _box(
    matrix: FloatArray,
    radius: float,
    half: FloatArray,
    rounding: float,
    sharp_to_boxes: bool = True,
) -> Core:
    """The core of a box.

    Args:
        matrix: from the box to the shape (4, 4).
        radius: metres by which it is grown.
        half: its half extents (3,) [m], rounding included.
        rounding: radius of its edges within that size [m].
        sharp_to_boxes: whether its edges are sharp where it meets another such box.
    """
    inner = min(rounding, float(np.min(half)))
    roundings = [inner, 0.0, rounding] if sharp_to_boxes else 3 * [inner]
    halves = np.array([np.maximum(half - each, 0.0) for each in roundings])
    return Core(
        Kind.BOX, matrix, [radius + each for each in roundings], halves, half, sharp_to_boxes
    )


def _hull(part: Primitive, points: FloatArray, rounding: float) -> Core:
    sharp = convex_hull(points)
    inner = shrunk_hull(sharp, rounding)
    if inner is None:
        inner, rounding = sharp, 0.0
    box = _as_box(sharp) if len(sharp.points) == 8 else None
    if box is not None:
        matrix, half = box
        return _box(part.matrix @ matrix, part.radius, half, rounding, sharp_to_boxes=False)
    radius = part.radius + rounding
    if len(inner.points) == 2:
        return _between(replace(part, radius=radius), inner.points)
    return replace(
        _simple(Kind.HULL, replace(part, radius=radius), (0, 0, 0)), hull=inner, sharp_hull=sharp
    )


def _between(part: Primitive, ends: FloatArray) -> Core:
    """A segment between two points."""
    along = ends[1] - ends[0]
    length = float(np.linalg.norm(along))
    local = np.eye(4)
    axis = along[:, None] / length
    local[:3, :3] = np.concatenate([*contact_plane(axis), axis], axis=1)
    local[:3, 3] = ends.mean(axis=0)
    return _simple(Kind.SEGMENT, replace(part, matrix=part.matrix @ local), (0, 0, length / 2))


def _as_box(hull: Hull) -> tuple[FloatArray, FloatArray] | None:
    """Matrix and half extents of the box whose eight corners these are, or None. Its axes are those
    nearest to x and y, and their cross product."""
    normals, _ = hull.planes()
    x = normals[normals[:, 0].argmax()]
    beside = normals[np.abs(normals @ x) < _SQUARE]
    if len(beside) == 0:
        return None
    y = beside[beside[:, 1].argmax()]
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([x, y, np.cross(x, y)], axis=1)
    local = hull.points @ matrix[:3, :3]
    centre = local.mean(axis=0)
    half = np.abs(local - centre).mean(axis=0)
    if np.abs(np.abs(local - centre) - half).max() > _SQUARE * half.max():
        return None
    matrix[:3, 3] = matrix[:3, :3] @ centre
    return matrix, half


@frozen
class Reduced:
    """The ``core`` of a primitive ``shape``, its bounds (2, 3) in its own frame, and its thickness
    [m]."""

    shape: Shape
    core: Core
    bounds: FloatArray
    thickness: float

    @classmethod
    def of(cls, part: Primitive, solid: bool) -> Reduced:
        """Reduce a primitive, wherever it is; ``solid``: a mesh counts as the volume of its convex
        hull."""
        core = _core(replace(part, matrix=np.eye(4)), solid)
        return cls(part.shape, core, core.bounds(), core.thickness())


@frozen
class CoreTable:
    """The cores of all bodies as arrays: those of body b are ``start[b] : start[b + 1]``.
    ``rotation`` (3, 3, c) and ``offset`` (3, c) place a core in its body, ``matrices`` (c, 4, 4) in
    its primitive; ``placed`` is False where all of the first are the identity. ``bound_centre`` and
    ``bound_half`` (3, c): box around the core in its own frame. ``thickness`` (b,) of each body's
    thinnest core [m]. ``reduced``: the primitives, by the id of their shape, the radius by which
    they are grown and whether they are volumes. The rest are the fields of `Core`: ``radius`` (3,
    c) and ``half`` (3, 3, c) by size."""

    cores: tuple[Core, ...]
    start: IntArray
    kind: IntArray
    matrices: FloatArray
    rotation: FloatArray
    offset: FloatArray
    placed: bool
    radius: FloatArray
    half: FloatArray
    outline: FloatArray
    is_box: BoolArray
    bound_centre: FloatArray
    bound_half: FloatArray
    thickness: FloatArray
    reduced: dict[tuple[int, float, bool], Reduced]

    @classmethod
    def of(
        cls, shapes: Sequence[Shape], solid: Sequence[bool], before: CoreTable | None = None
    ) -> CoreTable:
        """Tabulate the cores of ``shapes``; ``solid`` says which meshes are volumes. Equal
        primitives are reduced once, those that are the same object in the table ``before`` not
        again."""
        same = {} if before is None else before.reduced
        equal: dict[tuple[Shape, float, bool], Reduced] = {}
        reduced: dict[tuple[int, float, bool], Reduced] = {}
        per_body = [parts_of(shape) for shape in shapes]
        found = []
        for parts, volume in zip(per_body, solid, strict=True):
            for part in parts:
                key = id(part.shape), part.radius, volume
                if key not in reduced and key in same:
                    reduced[key] = same[key]
                elif key not in reduced:
                    content = part.shape, part.radius, volume
                    if content not in equal:
                        equal[content] = Reduced.of(part, volume)
                    reduced[key] = replace(equal[content], shape=part.shape)
                found.append(reduced[key])
        start = np.cumsum([0, *(len(parts) for parts in per_body)]).astype(np.int64)
        cores = tuple(each.core for each in found)
        placements = np.array(
            [part.matrix for parts in per_body for part in parts], dtype=np.float64
        ).reshape(-1, 4, 4)
        own = np.array([core.matrix for core in cores]).reshape(-1, 4, 4)
        matrices = placements @ own
        bounds = np.array([each.bounds for each in found], dtype=np.float64).reshape(-1, 2, 3)
        thickness = np.array([each.thickness for each in found], dtype=np.float64)
        return cls(
            radius=_columns([core.radius for core in cores]),
            half=np.array([_columns([core.half[size] for core in cores]) for size in Size]),
            outline=_columns([core.outline for core in cores]),
            cores=cores,
            start=start,
            kind=np.array([core.kind for core in cores], dtype=np.int64),
            matrices=own,
            rotation=matrices[:, :3, :3].transpose(1, 2, 0).copy(),
            offset=matrices[:, :3, 3].T.copy(),
            placed=not np.array_equal(matrices, np.broadcast_to(np.eye(4), matrices.shape)),
            is_box=np.array([core.is_box for core in cores], dtype=np.bool_),
            bound_centre=bounds.mean(axis=1).T.copy(),
            bound_half=(np.ptp(bounds, axis=1) / 2).T.copy(),
            thickness=np.minimum.reduceat(thickness, start[:-1]) if len(cores) else thickness,
            reduced=reduced,
        )

    def place(self, body: int, shape: Compound) -> None:
        """Place the cores of a body as in ``shape``, which differs from its own only in their
        places."""
        cores = slice(self.start[body], self.start[body + 1])
        matrices = places_of(shape) @ self.matrices[cores]
        self.rotation[..., cores] = matrices[:, :3, :3].transpose(1, 2, 0)
        self.offset[:, cores] = matrices[:, :3, 3].T


def _columns(vectors: Sequence[FloatArray | Sequence[float]]) -> FloatArray:
    return np.array(vectors, dtype=np.float64).reshape(-1, 3).T.copy()
