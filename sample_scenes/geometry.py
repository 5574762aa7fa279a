"""Shapes as plain vertices and faces, put together by ``+`` and made a Blender mesh at the end.
Lengths in metres, angles in radians."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise

import bpy
from bpy.types import Material, Mesh
from mathutils import Matrix, Vector

from ..core.frozen import frozen

Point = tuple[float, float, float]

SHARP_ANGLE = math.radians(38.0)

SUNK = 0.002
"""Overlap of objects with their supports [m], so that they touch reliably."""


@frozen
class Geometry:
    """Faces over vertices; ``paints`` holds the index of each face's material. ``a + b`` is both of
    them, side by side."""

    vertices: tuple[Point, ...]
    faces: tuple[tuple[int, ...], ...]
    paints: tuple[int, ...]

    def __add__(self, other: Geometry) -> Geometry:
        offset = len(self.vertices)
        moved = tuple(tuple(index + offset for index in face) for face in other.faces)
        return Geometry(
            self.vertices + other.vertices, self.faces + moved, self.paints + other.paints
        )

    def transformed(self, matrix: Matrix) -> Geometry:
        """All vertices transformed by ``matrix``."""
        return replace(
            self, vertices=tuple(tuple(matrix @ Vector(vertex)) for vertex in self.vertices)
        )

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Geometry:
        """Shifted by an offset."""
        return replace(self, vertices=tuple((a + x, b + y, c + z) for a, b, c in self.vertices))

    def turned(self, angle: float, axis: str) -> Geometry:
        """Turned about an axis (``X``, ``Y`` or ``Z``) through the origin."""
        return self.transformed(Matrix.Rotation(angle, 4, axis))

    def centre(self) -> Vector:
        """Centre of the bounding box."""
        columns = tuple(zip(*self.vertices, strict=True))
        return Vector([(min(column) + max(column)) / 2 for column in columns])

    def painted(self, paint: int) -> Geometry:
        """All faces with the material of that index."""
        return replace(self, paints=(paint,) * len(self.faces))


EMPTY = Geometry((), (), ())


def joined(parts: Iterable[Geometry]) -> Geometry:
    """All ``parts`` side by side."""
    return sum(parts, EMPTY)


def box(size: Point, chamfer: float = 0.0) -> Geometry:
    """A box about the origin; ``chamfer`` cuts its edges and corners without changing its
    extent."""
    half = tuple(side / 2 for side in size)
    if chamfer <= 0:
        corners = tuple(
            (x * half[0], y * half[1], z * half[2])
            for z in (-1, 1)
            for y in (-1, 1)
            for x in (-1, 1)
        )
        faces = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
        return Geometry(corners, faces, (0,) * 6)
    inner = tuple(h - min(chamfer, 0.49 * 2 * min(half)) for h in half)
    vertices: list[Point] = []
    index: dict[tuple[int, ...], int] = {}
    for z in (-1, 1):
        for y in (-1, 1):
            for x in (-1, 1):
                signs = (x, y, z)
                for axis in range(3):
                    index[(*signs, axis)] = len(vertices)
                    dx, dy, dz = (
                        s * (half[k] if k == axis else inner[k]) for k, s in enumerate(signs)
                    )
                    vertices.append((dx, dy, dz))
    faces_out: list[tuple[int, ...]] = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (-1, 1):
            face = []
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                corner = [0, 0, 0]
                corner[axis], corner[u], corner[v] = side, a, b
                face.append(index[(*corner, axis)])
            faces_out.append(tuple(face if side > 0 else reversed(face)))
        for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            low, high = [0, 0, 0], [0, 0, 0]
            low[axis], high[axis] = -1, 1
            low[u] = high[u] = a
            low[v] = high[v] = b
            edge = (index[(*low, u)], index[(*high, u)], index[(*high, v)], index[(*low, v)])
            faces_out.append(edge if a * b < 0 else edge[::-1])
    for z in (-1, 1):
        for y in (-1, 1):
            for x in (-1, 1):
                cut = tuple(index[(x, y, z, axis)] for axis in range(3))
                faces_out.append(cut if x * y * z > 0 else cut[::-1])
    return Geometry(tuple(vertices), tuple(faces_out), (0,) * len(faces_out))


def lathe(profile: Sequence[tuple[float, float]], segments: int = 24) -> Geometry:
    """The solid that a profile of (radius, z), from low to high z, sweeps about the z axis. Radius
    0 is a pole; open ends are closed."""
    vertices: list[Point] = []
    rings: list[list[int]] = []
    for radius, z in profile:
        count = 1 if radius <= 0 else segments
        rings.append(list(range(len(vertices), len(vertices) + count)))
        turns = (2 * math.pi * k / segments for k in range(count))
        vertices.extend((radius * math.cos(turn), radius * math.sin(turn), z) for turn in turns)
    faces: list[tuple[int, ...]] = []
    for low, high in pairwise(rings):
        for k in range(segments):
            ring = [
                low[k % len(low)],
                low[(k + 1) % len(low)],
                high[(k + 1) % len(high)],
                high[k % len(high)],
            ]
            face = tuple(dict.fromkeys(ring))
            if len(face) > 2:
                faces.append(face)
    if len(rings[0]) > 1:
        faces.append(tuple(reversed(rings[0])))
    if len(rings[-1]) > 1:
        faces.append(tuple(rings[-1]))
    return Geometry(tuple(vertices), tuple(faces), (0,) * len(faces))


def cylinder(radius: float, height: float, segments: int = 24, chamfer: float = 0.0) -> Geometry:
    """An upright cylinder about the origin."""
    h = height / 2
    if chamfer <= 0:
        return lathe(((radius, -h), (radius, h)), segments)
    return lathe(
        (
            (radius - chamfer, -h),
            (radius, chamfer - h),
            (radius, h - chamfer),
            (radius - chamfer, h),
        ),
        segments,
    )


def sphere(radius: float, segments: int = 24, rings: int = 12) -> Geometry:
    """A sphere about the origin."""
    return lathe(
        [
            (
                0.0 if k in (0, rings) else radius * math.sin(math.pi * k / rings),
                -radius * math.cos(math.pi * k / rings),
            )
            for k in range(rings + 1)
        ],
        segments,
    )


def superellipsoid(
    size: Point, roundness: float = 0.6, segments: int = 24, rings: int = 14
) -> Geometry:
    """A convex body that fills a box of ``size`` about the origin: an ellipsoid at roundness 1,
    towards the box itself near 0."""

    def power(value: float) -> float:
        return math.copysign(abs(value) ** roundness, value)

    ball = sphere(1.0, segments, rings)
    vertices = []
    for x, y, z in ball.vertices:
        around = math.hypot(x, y)
        turn = math.atan2(y, x)
        reach = power(around)
        vertices.append(
            (
                size[0] / 2 * reach * power(_clean(math.cos(turn))),
                size[1] / 2 * reach * power(_clean(math.sin(turn))),
                size[2] / 2 * power(_clean(z)),
            )
        )
    return replace(ball, vertices=tuple(vertices))


def limb(
    length: float, start: float, end: float, bulge: float = 0.0, segments: int = 20
) -> Geometry:
    """A tapered rod with round ends from the origin up to z = ``length``: radius ``start`` below,
    ``end`` above, ``bulge`` more between."""
    steps = 6
    profile: list[tuple[float, float]] = [(0.0, 0.0)]
    for k in range(1, steps + 1):
        turn = math.pi / 2 * k / steps
        profile.append((start * math.sin(turn), start * 0.6 * (1 - math.cos(turn))))
    low, high = start * 0.6, length - end * 0.6
    for k in range(1, 5):
        part = k / 5
        profile.append(
            (
                start + (end - start) * part + bulge * math.sin(math.pi * part),
                low + (high - low) * part,
            )
        )
    for k in range(steps):
        turn = math.pi / 2 * k / steps
        profile.append((end * math.cos(turn), high + end * 0.6 * math.sin(turn)))
    profile.append((0.0, length))
    return lathe(profile, segments)


def along(geometry: Geometry, start: Vector, end: Vector) -> Geometry:
    """``geometry``, which points up from the origin, set at ``start`` and pointing at ``end``."""
    turn = Vector((0.0, 0.0, 1.0)).rotation_difference(end - start).to_matrix().to_4x4()
    return geometry.transformed(Matrix.Translation(start) @ turn)


def rod(start: Point, end: Point, radius: float, segments: int = 12) -> Geometry:
    """A round bar from point to point."""
    a, b = Vector(start), Vector(end)
    return along(lathe(((radius, 0.0), (radius, (b - a).length)), segments), a, b)


def torus(radius: float, tube: float, segments: int = 32, sides: int = 12) -> Geometry:
    """A ring about the z axis; ``radius``: of the middle of its ``tube``."""
    turns = [2 * math.pi * k / segments for k in range(segments)]
    rounds = [2 * math.pi * k / sides for k in range(sides)]
    reach = [(radius + tube * math.cos(b), tube * math.sin(b)) for b in rounds]
    vertices = tuple((r * math.cos(a), r * math.sin(a), z) for a in turns for r, z in reach)
    count = len(vertices)
    faces = tuple(
        (
            k * sides + j,
            (k * sides + j + sides) % count,
            (k * sides + (j + 1) % sides + sides) % count,
            k * sides + (j + 1) % sides,
        )
        for k in range(segments)
        for j in range(sides)
    )
    return Geometry(vertices, faces, (0,) * len(faces))


def prism(outline: Sequence[tuple[float, float]], height: float) -> Geometry:
    """An outline in x and y, counter-clockwise, drawn out from z = 0 to ``height``."""
    count = len(outline)
    vertices = tuple((x, y, z) for z in (0.0, height) for x, y in outline)
    sides = tuple((k, (k + 1) % count, (k + 1) % count + count, k + count) for k in range(count))
    faces = (tuple(reversed(range(count))), tuple(range(count, 2 * count)), *sides)
    return Geometry(vertices, faces, (0,) * len(faces))


def to_mesh(name: str, geometry: Geometry, materials: Sequence[Material]) -> Mesh:
    """A Blender mesh, smooth except over sharp edges."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(geometry.vertices, [], geometry.faces)
    for material in materials:
        mesh.materials.append(material)
    mesh.polygons.foreach_set("material_index", geometry.paints)
    mesh.shade_smooth()
    mesh.set_sharp_from_angle(angle=SHARP_ANGLE)
    mesh.update()
    return mesh


def _clean(value: float) -> float:
    """Rounding noise of sine and cosine would grow under a root: 1e-16 ** 0.5 is 1e-8."""
    return 0.0 if abs(value) < 1e-12 else value
