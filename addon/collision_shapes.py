"""The collision shape of a Blender object, as Bullet would get it, as a value of the core."""

from __future__ import annotations

from typing import Any

import numpy as np
from bpy.types import Depsgraph, Object
from numpy.typing import NDArray

from ..core.contacts.shapes import Compound, Shape, convex_hull_shape, mesh_shape, shape_from_bounding_box
from ..core.scene import Pose

FloatArray = NDArray[np.float64]


def collision_shape(obj: Object, depsgraph: Depsgraph, scale: FloatArray) -> Shape:
    """The shape of ``obj`` with its world scale (3,) applied, in the object's rotated frame.

    A rigid body's own shape; else the convex hull of the evaluated mesh. Raises ValueError in words for a designer where there is none.
    """
    body = obj.rigid_body
    if body is None:
        return convex_hull_shape(_vertices(obj, depsgraph, "FINAL") * scale, margin=0.0)
    kind = body.collision_shape
    margin = body.collision_margin if body.use_margin else None
    if kind == "CONVEX_HULL":
        return convex_hull_shape(_vertices(obj, depsgraph, body.mesh_source) * scale, margin=margin)
    if kind == "MESH":
        vertices, triangles = _triangles(obj, depsgraph, body.mesh_source)
        return mesh_shape(vertices * scale, triangles, margin=body.collision_margin)
    if kind == "COMPOUND":
        return _compound(obj, depsgraph, scale)
    return shape_from_bounding_box(kind, _bounding_box(obj, depsgraph), scale, margin)


def _compound(obj: Object, depsgraph: Depsgraph, scale: FloatArray) -> Compound:
    """The children's shapes where they stand relative to their parent."""
    children = []
    inverse = obj.matrix_world.inverted_safe()
    for child in obj.children:
        if child.rigid_body is None:
            continue
        location, rotation, child_scale = (inverse @ child.matrix_world).decompose()
        world_scale = np.array(child.matrix_world.to_scale(), dtype=np.float64)
        shape = collision_shape(child, depsgraph, world_scale)
        pose = Pose(tuple(np.array(location, dtype=np.float64) * scale), (rotation.w, rotation.x, rotation.y, rotation.z))
        children.append((shape, pose))
    if not children:
        raise ValueError("its shape is Compound Parent, but no child is a rigid body")
    return Compound(tuple(children))


def _mesh_source(obj: Object, depsgraph: Depsgraph, source: str) -> tuple[Any, Object]:
    owner = obj if source == "BASE" else obj.evaluated_get(depsgraph)
    try:
        return owner.to_mesh(), owner
    except RuntimeError:
        raise ValueError(f"it is a {obj.type.lower()} and has no surface; use a mesh, or a listener or source on an empty") from None


def _vertices(obj: Object, depsgraph: Depsgraph, source: str) -> FloatArray:
    mesh, owner = _mesh_source(obj, depsgraph, source)
    try:
        return _read_vertices(mesh)
    finally:
        owner.to_mesh_clear()


def _read_vertices(mesh: Any) -> FloatArray:
    if mesh is None or len(mesh.vertices) == 0:
        raise ValueError("its mesh has no vertices")
    values = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", values)
    return values.reshape(-1, 3).astype(np.float64)


def _triangles(obj: Object, depsgraph: Depsgraph, source: str) -> tuple[FloatArray, NDArray[np.int64]]:
    mesh, owner = _mesh_source(obj, depsgraph, source)
    try:
        vertices = _read_vertices(mesh)
        mesh.calc_loop_triangles()
        if len(mesh.loop_triangles) == 0:
            raise ValueError("its mesh has no faces")
        triangles = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
        mesh.loop_triangles.foreach_get("vertices", triangles)
        return vertices, triangles.reshape(-1, 3).astype(np.int64)
    finally:
        owner.to_mesh_clear()


def _bounding_box(obj: Object, depsgraph: Depsgraph) -> FloatArray:
    """(2, 3): lowest and highest corner in local space, modifiers included."""
    corners = np.array(obj.evaluated_get(depsgraph).bound_box, dtype=np.float64)
    return np.stack([corners.min(axis=0), corners.max(axis=0)])
