"""The collision shape of a Blender object, as Blender passes it to Bullet, as a value of the core."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

import numpy as np
from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Depsgraph, Object

from ...core.arrays import FloatArray, IntArray
from ...core.contacts.bullet_shapes import DEFAULT_MARGIN, convex_hull_shape, mesh_shape, shape_from_bounding_box
from ...core.contacts.shapes import Compound, ConvexHull, Shape
from ...core.scene.values import Pose
from ..blender.arrays import read_array

LARGEST = 1e7
"""Largest extent of an object from its origin [m]; beyond it contacts are not accurate to a metre."""


def collision_shape(obj: Object, depsgraph: Depsgraph, scale: FloatArray) -> Shape:
    """The shape of ``obj`` with its world scale (3,), negative where mirrored, in the object's rotated frame.

    A rigid body's own shape, otherwise the convex hull of the evaluated mesh. Raises ValueError if there is none, or if it extends further
    than `LARGEST`.
    """
    if np.any(np.abs(scale) < 1e-9):
        raise ValueError(iface_("its scale is 0: give it an extent in every direction"))
    corners = np.abs(_bounding_box(obj, depsgraph) * scale)
    if np.any((corners > LARGEST) & np.isfinite(corners)):
        raise ValueError(iface_("it is larger than 10,000 km: reduce its scale, or mend its mesh"))
    size, mirror = np.abs(scale), np.sign(scale)
    body = obj.rigid_body
    if body is None:
        return ConvexHull(vertices_of(obj, depsgraph, "FINAL") * scale)
    margin, use_margin = body.collision_margin, body.use_margin
    match body.collision_shape:
        case "CONVEX_HULL":
            vertices = vertices_of(obj, depsgraph, body.mesh_source) * mirror
            return _hull(vertices.tobytes(), tuple(size.tolist()), margin, use_margin)
        case "MESH":
            vertices, triangles = _triangles(obj, depsgraph, body.mesh_source)
            return mesh_shape(vertices * mirror, triangles, size.tolist(), margin if use_margin else DEFAULT_MARGIN)
        case "COMPOUND":
            return _compound(obj, depsgraph, size)
        case kind:
            if not corners.any():
                raise ValueError(iface_("its mesh has no vertices"))
            return shape_from_bounding_box(kind, _bounding_box(obj, depsgraph), size.tolist(), margin, use_margin)


def mesh_checksum(obj: Object, depsgraph: Depsgraph) -> object:
    """Checksum of the geometry that the shape of ``obj`` is built from; never equal to another for compounds."""
    body = obj.rigid_body
    kind, source = ("CONVEX_HULL", "FINAL") if body is None else (body.collision_shape, body.mesh_source)
    match kind:
        case "COMPOUND":
            return object()
        case "CONVEX_HULL":
            return zlib.crc32(vertices_of(obj, depsgraph, source).tobytes())
        case "MESH":
            return tuple(zlib.crc32(part.tobytes()) for part in _triangles(obj, depsgraph, source))
        case _:
            return zlib.crc32(_bounding_box(obj, depsgraph).tobytes())


@lru_cache(maxsize=1024)
def _hull(vertices: bytes, size: tuple[float, ...], margin: float, use_margin: bool) -> Shape:
    """The hull of a mesh, shared by its objects, because shrinking it by the margin takes milliseconds. ``vertices``: (n, 3) as bytes."""
    return convex_hull_shape(np.frombuffer(vertices).reshape(-1, 3), size, margin, use_margin)


def _compound(obj: Object, depsgraph: Depsgraph, scale: FloatArray) -> Compound:
    """The children's shapes, placed relative to their parent."""
    children = []
    inverse = obj.matrix_world.inverted_safe()
    for child in obj.children:
        if child.rigid_body is None:
            continue
        location, rotation, _ = (inverse @ child.matrix_world).decompose()
        child_scale = np.array(child.matrix_world.to_scale(), dtype=np.float64)
        position = np.array(location, dtype=np.float64) * scale
        pose = Pose(tuple(position.tolist()), (rotation.w, rotation.x, rotation.y, rotation.z))
        children.append((collision_shape(child, depsgraph, child_scale), pose))
    if not children:
        raise ValueError(iface_("its shape is Compound Parent, but none of its children is a rigid body"))
    return Compound(tuple(children))


@contextmanager
def _surface(obj: Object, depsgraph: Depsgraph, source: str) -> Iterator[Any]:
    """The mesh of an object's surface, with its modifiers unless ``source`` is "BASE". Raises ValueError where it has none."""
    owner = obj if source == "BASE" else obj.evaluated_get(depsgraph)
    try:
        mesh = owner.to_mesh()
    except RuntimeError:
        words = iface_("it is a {} and has no surface; use a mesh, or a listener or source on an empty")
        raise ValueError(words.format(obj.type.lower())) from None
    try:
        if mesh is None or len(mesh.vertices) == 0:
            raise ValueError(iface_("its mesh has no vertices"))
        yield mesh
    finally:
        owner.to_mesh_clear()


def vertices_of(obj: Object, depsgraph: Depsgraph, source: str) -> FloatArray:
    """Corners (n, 3) of the surface of an object in its own space, see `_surface`."""
    with _surface(obj, depsgraph, source) as mesh:
        return read_array(mesh.vertices, "co", 3).astype(np.float64)


def _triangles(obj: Object, depsgraph: Depsgraph, source: str) -> tuple[FloatArray, IntArray]:
    with _surface(obj, depsgraph, source) as mesh:
        mesh.calc_loop_triangles()
        if len(mesh.loop_triangles) == 0:
            raise ValueError(iface_("its mesh has no faces"))
        triangles = read_array(mesh.loop_triangles, "vertices", 3, np.int32)
        return read_array(mesh.vertices, "co", 3).astype(np.float64), triangles.astype(np.int64)


def _bounding_box(obj: Object, depsgraph: Depsgraph) -> FloatArray:
    """(2, 3): lowest and highest corner in local space, including modifiers."""
    corners = np.array(obj.evaluated_get(depsgraph).bound_box, dtype=np.float64)
    return np.stack([corners.min(axis=0), corners.max(axis=0)])
