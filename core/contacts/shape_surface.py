"""Collision shapes as visible surfaces."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray, added_by
from .hull import convex_hull
from .shapes import (
    Box,
    Capsule,
    Compound,
    Cone,
    ConvexHull,
    Cylinder,
    Mesh,
    Shape,
    Sphere,
)

Surface = tuple[FloatArray, list[tuple[int, ...]]]
"""Points (n, 3), and faces as indices of points."""

SEGMENTS = 24
RINGS = 6

_BENT = 0.99999
"""Length of the mean of the unit normals of two faces below which there is an edge between them."""


def surface(shape: Shape) -> Surface:
    """The surface of a shape's core, in its own space [m]. Round ones stand along z."""
    match shape:
        case Box(size=size):
            corners = np.array(
                [[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
            )
            return corners * size, [
                (0, 1, 3, 2),
                (4, 6, 7, 5),
                (0, 4, 5, 1),
                (2, 3, 7, 6),
                (0, 2, 6, 4),
                (1, 5, 7, 3),
            ]
        case Sphere(radius=radius):
            return _turned([(r, z) for r, z in _arc(radius, 0.0, -90, 90)])
        case Capsule(radius=radius, height=height):
            return _turned([*_arc(radius, -height / 2, -90, 0), *_arc(radius, height / 2, 0, 90)])
        case Cylinder(radius=radius, height=height):
            return _turned(
                [(0.0, -height / 2), (radius, -height / 2), (radius, height / 2), (0.0, height / 2)]
            )
        case Cone(radius=radius, height=height):
            return _turned([(0.0, -height / 2), (radius, -height / 2), (0.0, height / 2)])
        case ConvexHull(points=points):
            hull = convex_hull(points)
            # A flat hull contains both sides of each face.
            flat = {frozenset(face): tuple(face) for face in hull.triangles.tolist()}
            return hull.points, list(flat.values())
        case Mesh(points=points, triangles=triangles):
            return np.array(points), [tuple(face) for face in triangles.tolist()]
        case Compound(parts=parts, places=places):
            return _joined(
                [(*surface(part), place) for part, place in zip(parts, places, strict=True)]
            )
    raise ValueError(f"There is no surface for a {shape.type}")


def edges(shape: Shape) -> tuple[FloatArray, IntArray]:
    """The points (n, 3) of a shape's surface, and its edges (m, 2), each once, without those within
    a flat face."""
    points, faces = surface(shape)
    sides = np.array(
        [pair for face in faces for pair in zip(face, (*face[1:], face[0]), strict=True)],
        dtype=np.int64,
    ).reshape(-1, 2)
    a, b, c = (points[[face[k] for face in faces]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    each = normal.repeat([len(face) for face in faces], axis=0)
    unique, number, count = np.unique(
        np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    common = added_by(number.reshape(-1), each.T, len(unique)) / count
    return points, unique[(count < 2) | (np.linalg.norm(common, axis=0) < _BENT)]


def _arc(radius: float, centre: float, start: float, end: float) -> list[tuple[float, float]]:
    """Distances from the axis and heights along a quarter or half circle, angles in degrees."""
    count = RINGS * 2 if end - start > 90 else RINGS
    angles = np.radians(np.linspace(start, end, count + 1))
    return list(
        zip(
            (radius * np.cos(angles)).tolist(),
            (centre + radius * np.sin(angles)).tolist(),
            strict=True,
        )
    )


def _turned(profile: list[tuple[float, float]]) -> Surface:
    """The surface of revolution of an upward profile (distance from the axis, height) around the z
    axis; its ends lie on the axis."""
    angles = 2 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    inner = profile[1:-1]
    rings = [
        np.column_stack([r * np.cos(angles), r * np.sin(angles), np.full(SEGMENTS, z)])
        for r, z in inner
    ]
    points = np.concatenate([[[0.0, 0.0, profile[0][1]]], *rings, [[0.0, 0.0, profile[-1][1]]]])
    last = len(points) - 1
    faces: list[tuple[int, ...]] = []
    for k in range(SEGMENTS):
        n = (k + 1) % SEGMENTS
        faces.append((0, 1 + n, 1 + k))
        for ring in range(len(inner) - 1):
            low = 1 + ring * SEGMENTS
            high = 1 + (ring + 1) * SEGMENTS
            faces.append((low + k, low + n, high + n, high + k))
        top = 1 + (len(inner) - 1) * SEGMENTS
        faces.append((top + k, top + n, last))
    return points, faces


def _joined(parts: list[tuple[FloatArray, list[tuple[int, ...]], FloatArray]]) -> Surface:
    """The surfaces of several parts, each with its transform (4, 4), as one."""
    starts = np.cumsum([0, *(len(points) for points, _, _ in parts)]).tolist()
    faces = [
        tuple(start + i for i in face)
        for start, (_, own, _) in zip(starts, parts, strict=False)
        for face in own
    ]
    return np.concatenate(
        [points @ matrix[:3, :3].T + matrix[:3, 3] for points, _, matrix in parts]
    ), faces
