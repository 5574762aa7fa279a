"""The collision shape of a Blender object, as Blender passes it to Bullet, as a value of the
core."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from bpy.app.translations import pgettext_iface as iface_
from bpy.types import ClothModifier, Depsgraph, Mesh, Object, Scene, SoftBodyModifier

from ...core.arrays import FloatArray, IntArray
from ...core.contacts.bullet_shapes import (
    DEFAULT_MARGIN,
    convex_hull_shape,
    mesh_shape,
    shape_from_bounding_box,
)
from ...core.contacts.shapes import MAX_TRIANGLES, Compound, ConvexHull
from ...core.contacts.shapes import Mesh as MeshShape
from ...core.contacts.surface_shape import Surface, SurfaceShape, hull_deviation, surface_shape
from ...core.scene.values import Pose
from ..blender.arrays import read_array
from ..blender.units import metres_per_unit
from .instances import HapticInstance
from .world_transforms import apply_stretch, lengths_of_axes

_MOST_KEPT = 20_000
"""Triangles up to which the shape of a mesh is kept."""

LARGEST = 1e7
"""Largest extent of an object from its origin [m]; beyond it contacts are not accurate to a
metre."""


def shape_settings(obj: Object, scene: Scene) -> tuple[Any, ...]:
    """What the shape of ``obj`` depends on beside its geometry and stretch."""
    body = obj.rigid_body
    if body is None:
        return obj.haptics.surface, scene.haptics.contact_tolerance
    margin = body.collision_margin * metres_per_unit(scene)
    return body.collision_shape, body.mesh_source, body.use_margin, margin


def distance_of_cloth(obj: Object, scene: Scene) -> float:
    """How far from what it collides with Blender lets a cloth or soft body rest [m]; 0 of all other
    objects, and where nothing collides with it."""
    for modifier in obj.modifiers:
        if isinstance(modifier, ClothModifier) and modifier.collision_settings.use_collision:
            own, group = (
                modifier.collision_settings.distance_min,
                modifier.collision_settings.collection,
            )
        elif isinstance(modifier, SoftBodyModifier):
            own, group = 0.0, modifier.settings.collision_collection
        else:
            continue
        others = scene.objects if group is None else group.all_objects
        colliders = [other.collision for other in others if other.collision is not None]
        thickness = [collider.thickness_outer for collider in colliders if collider.use]
        return (own + max(thickness)) * metres_per_unit(scene) if thickness else 0.0
    return 0.0


def collision_shape(
    obj: Object, depsgraph: Depsgraph, stretch: FloatArray, margin: float = 0.0
) -> SurfaceShape:
    """The shape of ``obj`` with its world ``stretch`` (6,) [m per unit of the mesh], see
    `rigid_transforms`, in the object's rotated frame. ``margin`` [m]: its `distance_of_cloth`.

    A rigid body's own shape, which Blender does not shear, otherwise what the object's *Surface*
    says of the evaluated mesh. Raises ValueError if there is none, or if it extends further than
    `LARGEST`.
    """
    scale = stretch[:3]
    if np.any(np.abs(scale) < 1e-9):
        raise ValueError(iface_("its scale is 0: give it an extent in every direction"))
    bounds = _bounding_box(obj, depsgraph)
    corners = np.abs(bounds * scale)
    if np.any((corners > LARGEST) & np.isfinite(corners)):
        raise ValueError(iface_("it is larger than 10,000 km: reduce its scale, or mend its mesh"))
    if obj.rigid_body is None:
        surface = _triangles(obj, depsgraph, "FINAL")
        found = _shape_of_surface(obj, *surface, depsgraph.scene, stretch)
        assert isinstance(found.shape, ConvexHull | MeshShape)
        return replace(found, shape=replace(found.shape, margin=margin)) if margin else found
    return _shape_of_body(obj, depsgraph, bounds, np.sign(scale) * lengths_of_axes(stretch))


def shape_of_instance(
    found: HapticInstance, depsgraph: Depsgraph, stretch: FloatArray
) -> SurfaceShape:
    """The shape of an instance: that of the object which it shows, or of a mesh without an object.
    Raises ValueError as `collision_shape` does."""
    shown, owner = found.shown, found.owner
    if shown.original == owner and owner != found.instancer:
        margin = distance_of_cloth(owner, depsgraph.scene)
        return collision_shape(owner, depsgraph, stretch, margin)
    if not isinstance(shown.data, Mesh) or len(shown.data.vertices) == 0:
        raise ValueError(iface_("its mesh has no vertices"))
    points, triangles = _arrays_of(shown.data)
    return _shape_of_surface(owner, points, triangles, depsgraph.scene, stretch)


def _shape_of_surface(
    owner: Object, vertices: FloatArray, triangles: IntArray, scene: Scene, stretch: FloatArray
) -> SurfaceShape:
    """What the *Surface* of an object says of these triangles.

    Args:
        owner: the object whose properties count.
        vertices: (n, 3) in its own space.
        triangles: (t, 3) over them.
        scene: whose contact tolerance counts.
        stretch: of the object in the world (6,).
    """
    haptics = owner.haptics
    outwards = triangles if stretch[:3].prod() > 0 else triangles[:, ::-1]
    surface = Surface(haptics.surface.lower())
    tolerance = scene.haptics.contact_tolerance / 10
    if surface is not Surface.CONVEX_HULL:
        _check_number(triangles)
    points = apply_stretch(vertices, stretch)
    if len(triangles) > _MOST_KEPT:
        return surface_shape(points, outwards, surface, tolerance)
    return _surface_shape(points.tobytes(), outwards.tobytes(), surface, tolerance)


def _shape_of_body(
    obj: Object, depsgraph: Depsgraph, bounds: FloatArray, scale: FloatArray
) -> SurfaceShape:
    """The shape of a rigid body with these ``bounds`` (2, 3) in its own space; ``scale`` (3,)
    along its axes, negative where mirrored."""
    body: Any = obj.rigid_body
    size = np.abs(scale)
    mirror = np.sign(scale)
    metres = metres_per_unit(depsgraph.scene)
    own = body.collision_margin * metres
    margin = own if body.use_margin else DEFAULT_MARGIN * metres
    match body.collision_shape:
        case "CONVEX_HULL":
            vertices, triangles = _triangles(obj, depsgraph, body.mesh_source)
            return _hull(
                (vertices * mirror).tobytes(),
                triangles.tobytes(),
                tuple(size.tolist()),
                own if body.use_margin else None,
            )
        case "MESH":
            vertices, triangles = _triangles(obj, depsgraph, body.mesh_source)
            if len(triangles) == 0:
                raise ValueError(iface_("its mesh has no faces"))
            _check_number(triangles)
            return SurfaceShape(mesh_shape(vertices * mirror, triangles, size.tolist(), margin))
        case "COMPOUND":
            return SurfaceShape(_compound(obj, depsgraph, size))
        case kind:
            if not bounds.any():
                raise ValueError(_why_empty(obj))
            outside = own if kind == "CONE" else margin
            return SurfaceShape(shape_from_bounding_box(kind, bounds, size.tolist(), outside))


def mesh_number(obj: Object, depsgraph: Depsgraph) -> int:
    """A number of the evaluated mesh that an object shows, the same of objects that share it until
    the next evaluation; 0 without a mesh, and of a compound, which depends on others."""
    is_compound = obj.rigid_body is not None and obj.rigid_body.collision_shape == "COMPOUND"
    data = obj.evaluated_get(depsgraph).data
    return data.as_pointer() if isinstance(data, Mesh) and not is_compound else 0


def hides_multires(obj: Object) -> bool:
    """Whether Blender evaluates an object without its Multiresolution, which Sculpt Mode shows in
    its own way."""
    return obj.mode == "SCULPT" and any(item.type == "MULTIRES" for item in obj.modifiers)


def mesh_checksum(obj: Object, depsgraph: Depsgraph) -> object:
    """Checksum of the geometry that the shape of ``obj`` is built from. That of a compound differs
    at each call, so that its shape is always built again."""
    body = obj.rigid_body
    kind, source = ("MESH", "FINAL") if body is None else (body.collision_shape, body.mesh_source)
    match kind:
        case "COMPOUND":
            return object()
        case "CONVEX_HULL" | "MESH":
            with _surface(obj, depsgraph, source) as mesh:
                sizes = read_array(mesh.polygons, "loop_total", 1, np.int32)
                places = read_array(mesh.vertices, "co", 3)
                return tuple(zlib.crc32(part.tobytes()) for part in (places, _corners(mesh), sizes))
        case _:
            return zlib.crc32(_bounding_box(obj, depsgraph).tobytes())


@lru_cache(maxsize=1024)
def _hull(
    vertices: bytes, triangles: bytes, size: tuple[float, ...], margin: float | None
) -> SurfaceShape:
    """The hull of a mesh, shared by its objects, because shrinking it by the margin takes
    milliseconds. ``vertices``: (n, 3) as bytes, ``triangles`` (t, 3) too."""
    points = np.frombuffer(vertices).reshape(-1, 3)
    shape = convex_hull_shape(points, size, margin)
    return SurfaceShape(
        shape,
        hull_deviation(points * size, np.frombuffer(triangles, dtype=np.int64).reshape(-1, 3)),
    )


@lru_cache(maxsize=256)
def _surface_shape(
    vertices: bytes, triangles: bytes, surface: Surface, tolerance: float
) -> SurfaceShape:
    """`surface_shape` of a mesh, kept by its content: undo and duplicates read it again.

    Args:
        vertices: (n, 3) as bytes [m].
        triangles: (t, 3) as bytes.
        surface: what of the mesh touches others.
        tolerance: as of `surface_shape` [m].
    """
    points = np.frombuffer(vertices).reshape(-1, 3)
    corners = np.frombuffer(triangles, dtype=np.int64).reshape(-1, 3)
    return surface_shape(points, corners, surface, tolerance)


def _compound(obj: Object, depsgraph: Depsgraph, scale: FloatArray) -> Compound:
    """The children's shapes, placed relative to their parent."""
    children = []
    inverse = obj.matrix_world.inverted_safe()
    metres = metres_per_unit(depsgraph.scene)
    for child in obj.children:
        if child.rigid_body is None:
            continue
        location, rotation, _ = (inverse @ child.matrix_world).decompose()
        stretch = metres * np.array([*child.matrix_world.to_scale(), 0.0, 0.0, 0.0])
        position = np.array(location, dtype=np.float64) * scale
        pose = Pose(tuple(position.tolist()), (rotation.w, rotation.x, rotation.y, rotation.z))
        children.append((collision_shape(child, depsgraph, stretch).shape, pose))
    if not children:
        raise ValueError(
            iface_("its shape is Compound Parent, but none of its children is a rigid body")
        )
    return Compound.of(children)


@contextmanager
def _surface(obj: Object, depsgraph: Depsgraph, source: str) -> Iterator[Any]:
    """The mesh of an object's surface, with its modifiers unless ``source`` is "BASE". Raises
    ValueError where it has none."""
    owner = obj if source == "BASE" else obj.evaluated_get(depsgraph)
    try:
        mesh = owner.to_mesh()
    except RuntimeError:
        words = iface_(
            "its type, {}, has no surface: use a mesh, or a listener or source on an empty"
        )
        types = obj.bl_rna.properties["type"].enum_items
        raise ValueError(words.format(iface_(types[obj.type].name))) from None
    try:
        if mesh is None or len(mesh.vertices) == 0:
            raise ValueError(_why_empty(obj))
        yield mesh
    finally:
        owner.to_mesh_clear()


def _why_empty(obj: Object) -> str:
    """Why the surface of an object has no vertices."""
    data = obj.data
    if data is not None and data.library is not None and data.is_missing:
        words = iface_(
            "its mesh is not in the library {}: use File > External Data > Find Missing Files"
        )
        return words.format(data.library.filepath)
    # In Edit Mode, that is the mesh before it.
    if isinstance(data, Mesh) and len(data.vertices) > 0 and not data.is_editmode:
        return iface_("its modifiers leave no vertices of its mesh")
    return iface_("its mesh has no vertices")


def vertices_of(obj: Object, depsgraph: Depsgraph, source: str) -> FloatArray:
    """Corners (n, 3) of the surface of an object in its own space, see `_surface`."""
    with _surface(obj, depsgraph, source) as mesh:
        return read_array(mesh.vertices, "co", 3).astype(np.float64)


def _triangles(obj: Object, depsgraph: Depsgraph, source: str) -> tuple[FloatArray, IntArray]:
    with _surface(obj, depsgraph, source) as mesh:
        return _arrays_of(mesh)


def _arrays_of(mesh: Mesh) -> tuple[FloatArray, IntArray]:
    """Its vertices (n, 3) and triangles (t, 3). Raises ValueError where it has no extent."""
    mesh.calc_loop_triangles()
    triangles = _corners(mesh)[read_array(mesh.loop_triangles, "loops", 3, np.int32)]
    vertices = read_array(mesh.vertices, "co", 3).astype(np.float64)
    if not np.ptp(vertices, axis=0).any():
        raise ValueError(iface_("its vertices are all in one place: move them apart"))
    return vertices, triangles.astype(np.int64)


def _corners(mesh: Mesh) -> IntArray:
    """The vertices (c,) of all faces, one face after the other; Blender's attribute is read in a
    hundredth of the time that its loops or the vertices of its triangles take."""
    attribute: Any = mesh.attributes.get(".corner_vert")
    if attribute is None:
        return np.zeros(0, dtype=np.int32)
    return read_array(attribute.data, "value", 1, np.int32).reshape(-1)


def _check_number(triangles: IntArray) -> None:
    """Raises ValueError where there are too many triangles to collide."""
    if len(triangles) > MAX_TRIANGLES:
        words = iface_(
            "its surface has {:,} triangles, more than {:,}: choose Convex Hull, or add a "
            "Decimate modifier"
        )
        raise ValueError(words.format(len(triangles), MAX_TRIANGLES))


def _bounding_box(obj: Object, depsgraph: Depsgraph) -> FloatArray:
    """(2, 3): lowest and highest corner in local space, including modifiers."""
    corners = np.array(obj.evaluated_get(depsgraph).bound_box, dtype=np.float64)
    return np.stack([corners.min(axis=0), corners.max(axis=0)])
