"""The shape of a mesh that bones deform: a convex part for each bone, of the vertices that it moves
most, which moves with the bone.

A mesh is read in its rest pose, as it is without modifiers; each frame only the bones' matrices.
"""

from __future__ import annotations

import zlib
from functools import lru_cache
from typing import Any

import numpy as np
from bpy.types import Depsgraph, Mesh, Object

from ...core.arrays import FloatArray, IntArray
from ...core.contacts.hull import convex_hull
from ...core.contacts.shapes import Compound, ConvexHull, Shape, quaternions
from ...core.contacts.surface_shape import hull_deviation
from ...core.frozen import frozen
from ...core.scene.body import heel_mass
from ...core.scene.skeleton import part_in
from ...core.scene.values import Pose
from ..blender.arrays import read_array
from ..blender.units import metres_per_unit
from .world_transforms import apply_stretch, in_metres, rigid_transforms

_KEEP_PLACES = {
    *("ARMATURE", "CORRECTIVE_SMOOTH", "DECIMATE", "EDGE_SPLIT", "LAPLACIANSMOOTH", "MULTIRES"),
    *("NORMAL_EDIT", "SMOOTH", "SOLIDIFY", "SUBSURF", "TRIANGULATE", "UV_PROJECT", "UV_WARP"),
    *("VERTEX_WEIGHT_EDIT", "VERTEX_WEIGHT_MIX", "WEIGHTED_NORMAL", "WELD"),
}
"""Types of modifiers after which the vertices of the mesh are still the first ones, or fewer, about
where the armature moved them."""

_SMOOTH = 5e-4
"""Metres by which vertices of a part may be outside its hull: a limb of thousands of vertices needs
some hundred."""

_STRETCHED = 1e-3
"""Part by which a bone may change lengths without a shape of its own for that."""


@frozen
class BoneParts:
    """The parts of a mesh at rest, in the object's frame with its scale in them: ``points`` (n, 3)
    of its vertices and the number (n,) of the part of each, the hulls of the parts as the
    ``shape``, and by part the number of the bone in the pose, -1 for what no bone moves, and the
    inverse (4, 4) of its matrix at rest. ``limbs`` as in `Body`. ``concavity`` [m]: how far the
    hulls are beside the surface."""

    points: FloatArray
    of: IntArray
    shape: Compound
    bones: IntArray
    inverse_rest: FloatArray
    limbs: tuple[float, ...]
    concavity: float

    def motions(self, obj: Object, armature: Object, depsgraph: Depsgraph) -> FloatArray:
        """How the bones have moved the parts, as affine maps (p, 4, 4) in the object's frame."""
        pose = armature.evaluated_get(depsgraph)
        bones = read_array(pose.pose.bones, "matrix", 16).reshape(-1, 4, 4).transpose(0, 2, 1)
        moved = bones[self.bones] @ self.inverse_rest
        moved[self.bones < 0] = np.eye(4)
        world = np.array(obj.evaluated_get(depsgraph).matrix_world, dtype=np.float32)
        metres = metres_per_unit(depsgraph.scene)
        rigid = rigid_transforms(in_metres(world.T.reshape(1, 16), metres))[0][0]
        of_armature = np.array(pose.matrix_world)
        of_armature[:3] *= metres
        to_object = np.linalg.inv(rigid) @ of_armature
        return np.asarray(to_object @ moved @ np.linalg.inv(to_object))

    def posed(self, motions: FloatArray) -> Compound:
        """The parts after these ``motions``; where a bone stretches, its hull is stretched."""
        linear = motions[:, :3, :3]
        products = linear.transpose(0, 2, 1) @ linear
        stretched = np.abs(products - np.eye(3)).max(axis=(1, 2)) > 2 * _STRETCHED
        hulls = dict[int, ConvexHull]()
        turns = linear.copy()
        for part in np.flatnonzero(stretched).tolist():
            left, sizes, right = np.linalg.svd(linear[part])
            side = np.sign(np.linalg.det(left @ right))  # -1 where the bone mirrors
            turns[part] = side * (left @ right)
            stretch = np.round(right.T * (side * sizes) @ right, 3)
            hulls[part] = _stretched(self.shape.parts[part], stretch.tobytes())
        poses = np.concatenate([motions[:, :3, 3], quaternions(turns)], axis=1)
        if not hulls:
            return self.shape.posed(poses)
        return Compound(tuple(hulls.get(k, part) for k, part in enumerate(self.shape.parts)), poses)

    def deviation(
        self, motions: FloatArray, obj: Object, depsgraph: Depsgraph, stretch: FloatArray
    ) -> float:
        """A bound on the distance between the parts and the surface as it is deformed now [m]: that
        of the hulls at rest, plus the largest distance of a vertex from where its bone alone would
        move it."""
        mesh = obj.evaluated_get(depsgraph).data
        if len(mesh.vertices) < len(self.points):
            return self.concavity
        seen = apply_stretch(read_array(mesh.vertices, "co", 3)[: len(self.points)], stretch)
        motion = motions[self.of]
        alone = np.einsum("nij,nj->ni", motion[:, :3, :3], self.points) + motion[:, :3, 3]
        return self.concavity + float(np.sqrt(((seen - alone) ** 2).sum(axis=1).max()))


def armature_of(obj: Object) -> Object | None:
    """The armature whose bones alone deform a mesh, None if there is none or if other modifiers
    do, too."""
    if obj.type != "MESH":
        return None
    active: list[Any] = [item for item in obj.modifiers if item.show_viewport]
    armatures = {item.object for item in active if item.type == "ARMATURE" and item.object}
    if any(item.type not in _KEEP_PLACES for item in active) or len(armatures) > 1:
        return None
    if obj.parent_type == "ARMATURE" and obj.parent is not None:  # as files before 2.5 have it
        armatures.add(obj.parent)
    return armatures.pop() if len(armatures) == 1 else None


def rest_checksum(obj: Object, armature: Object) -> tuple[object, ...]:
    """What the parts depend on beside the weights and the stretch: names of bones and vertex
    groups, matrices and places at rest."""
    bones = armature.data.bones
    return (
        armature.name_full,
        (*bones.keys(), *obj.vertex_groups.keys()),
        read_array(bones, "use_deform", 1, np.bool_).tobytes(),
        zlib.crc32(read_array(bones, "matrix_local", 16).tobytes()),
    )


def parts_at_rest(obj: Object, armature: Object, stretch: FloatArray) -> BoneParts | None:
    """The parts of a mesh with its world ``stretch`` (6,); None if the bones move none of it."""
    mesh = obj.data
    points = apply_stretch(read_array(mesh.vertices, "co", 3), stretch)
    names = [bone.name for bone in armature.pose.bones if bone.bone.use_deform]
    bone_of = {
        group.index: armature.pose.bones.find(group.name)
        for group in obj.vertex_groups
        if group.name in names
    }
    mesh.calc_loop_triangles()
    triangles = read_array(mesh.loop_triangles, "vertices", 3, np.int32)
    while True:
        moved_by = _strongest(mesh, bone_of)
        bones, of = np.unique(moved_by, return_inverse=True)
        groups = [points[of == part] for part in range(len(bones))]
        flat = [bone for bone, own in zip(bones.tolist(), groups, strict=True) if _is_point(own)]
        if not set(flat) & set(bone_of.values()):
            break
        bone_of = {group: bone for group, bone in bone_of.items() if bone not in flat}
    if not bone_of or any(map(_is_point, groups)):
        return None
    inside = of[triangles]
    whole = (inside == inside[:, :1]).all(axis=1)
    place = np.empty(len(points), dtype=np.int64)
    parts = []
    for part, own in enumerate(groups):
        place[of == part] = np.arange(len(own))
        mine = place[triangles[whole & (inside[:, 0] == part)]]
        parts.append(_hull(own.tobytes(), mine.tobytes()))
    hulls, deviations = zip(*parts, strict=True)
    rest = read_array(armature.data.bones, "matrix_local", 16).reshape(-1, 4, 4)
    data = [armature.data.bones.find(bone.name) for bone in armature.pose.bones]
    inverse = np.linalg.inv(rest.transpose(0, 2, 1).astype(np.float64))[np.array(data)[bones]]
    shape = Compound.of((hull, Pose()) for hull in hulls)
    heel = heel_mass(_height(obj, armature, stretch))
    names = [armature.pose.bones[bone].name if bone >= 0 else "" for bone in bones.tolist()]
    limbs = tuple(heel if part_in(name) == "foot" else 0.0 for name in names)
    return BoneParts(points, of, shape, bones, inverse, limbs, max(deviations))


def _height(obj: Object, armature: Object, stretch: FloatArray) -> float:
    """The largest extent [m] of the bones at rest that deform a mesh."""
    bones = [bone for bone in armature.data.bones if bone.use_deform]
    to_object = obj.matrix_world.inverted_safe() @ armature.matrix_world
    ends = [to_object @ end for bone in bones for end in (bone.head_local, bone.tail_local)]
    return float(np.ptp(apply_stretch(np.array(ends), stretch), axis=0).max())


def _strongest(mesh: Mesh, bone_of: dict[int, int]) -> IntArray:
    """For each vertex the bone with the largest weight, of those of the vertex groups in
    ``bone_of``; -1 where none has any."""
    found = []
    for vertex in mesh.vertices:
        most, strongest = 0.0, -1
        for entry in vertex.groups:
            if entry.weight > most and entry.group in bone_of:
                most = entry.weight
                strongest = bone_of[entry.group]
        found.append(strongest)
    return np.array(found, dtype=np.int64)


def _is_point(points: FloatArray) -> bool:
    return not np.ptp(points, axis=0).any()


@lru_cache(maxsize=1024)
def _hull(points: bytes, triangles: bytes) -> tuple[ConvexHull, float]:
    """The hull of points (n, 3), and how far it is at most from them and from triangles (t, 3) of
    them [m]; the same object where a mesh is read again, as after every edit of a property."""
    own = np.frombuffer(points).reshape(-1, 3)
    hull = ConvexHull(convex_hull(own, _SMOOTH).points)
    normals, offsets = convex_hull(hull.points).planes()
    beyond = float(((own @ normals.T).max(axis=0) - offsets).max(initial=0.0))
    mine = np.frombuffer(triangles, dtype=np.int64).reshape(-1, 3)
    return hull, max(beyond, hull_deviation(own, mine, _SMOOTH))


@lru_cache(maxsize=256)
def _stretched(hull: Shape, stretch: bytes) -> ConvexHull:
    assert isinstance(hull, ConvexHull)
    return ConvexHull(hull.points @ np.frombuffer(stretch).reshape(3, 3))
