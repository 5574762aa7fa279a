"""Six scenes of concave, skinned and many objects, made by formulas, as content that is imported
has them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import bpy
import numpy as np
from bpy.types import Mesh, Object, Scene
from haptic_tracing.sample_scenes.avatar import Hand, standing
from haptic_tracing.sample_scenes.real_content import add_character
from mathutils import Vector

FRAMES = 60

Profile = Sequence[tuple[float, float]]
"""Radii and heights of the outline of a body of revolution, upwards outside, downwards inside."""

_BOWL = (0.05, 0.0), (0.11, 0.06), (0.1, 0.06), (0.04, 0.01)
_LINK = (0.09, 0.0), (0.09, 0.03), (0.05, 0.05), (0.05, 0.25), (0.09, 0.27), (0.09, 0.3)
_HANGING = Hand(Vector((0.3, -0.06, 0.86)), Vector((0.1, -0.25, -1.0)), Vector((1.0, 0.0, 0.0)))
_RING = (0.3, 0.0), (0.36, 0.05), (0.3, 0.1), (0.24, 0.05)


def _object(name: str, mesh: Mesh, place: Sequence[float] = (0, 0, 0)) -> Object:
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    obj.location = place
    return obj


def _box(name: str, size: Sequence[float]) -> Mesh:
    x, y, z = np.array(size) / 2
    corners = [(a * x, b * y, c * z) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], faces)
    return mesh


def _turned(name: str, profile: Profile, sides: int = 24, rings: bool = False) -> Mesh:
    """A body of revolution; ``rings``: around a hole, otherwise closed at both ends."""
    angles = 2 * np.pi * np.arange(sides) / sides
    points = [(r * np.cos(a), r * np.sin(a), z) for r, z in profile for a in angles]
    count = len(profile)
    faces: list[tuple[int, ...]] = [
        (
            k * sides + a,
            k * sides + (a + 1) % sides,
            (k + 1) % count * sides + (a + 1) % sides,
            (k + 1) % count * sides + a,
        )
        for k in range(count if rings else count - 1)
        for a in range(sides)
    ]
    if not rings:
        last = (count - 1) * sides
        faces += [tuple(range(sides - 1, -1, -1)), tuple(range(last, last + sides))]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], faces)
    return mesh


def _moved(obj: Object, way: Sequence[float], frames: int = FRAMES) -> Object:
    begin = np.array(obj.location)
    for frame, share in ((1, 0.0), (frames // 2, 1.0), (frames, 0.0)):
        obj.location = begin + share * np.array(way)
        obj.keyframe_insert("location", frame=frame)
    return obj


def kitchen() -> None:
    """240 objects: a worktop with bowls in each other, shelves, a pan that is pushed along."""
    _object("Floor", _box("floor", (6, 4, 0.2)), (0, 0, -0.1))
    bowl, shelf = _turned("bowl", _BOWL), _box("shelf", (3.9, 0.5, 0.02))
    for k in range(8):
        _object(f"Shelf.{k:03d}", shelf, (0, 1.0, 0.3 * k + 0.01))
        _object(f"Side.{k:03d}", _box("side", (0.05, 0.5, 0.27)), (1.9, 1.0, 0.3 * k + 0.155))
    for k in range(222):
        level, number = divmod(k, 28)
        column, layer = divmod(number, 2)
        place = 0.26 * column - 1.82, 1.0, 0.3 * level + 0.02 + 0.02 * layer
        _object(f"Bowl.{k:03d}", bowl, place)
    _moved(_object("Pan", _turned("pan", _BOWL, 48), (-1, 0, 0)), (1, 0, 0))


def robots() -> None:
    """65 links: two arms and six legs on a table, all of whose joints turn."""
    _object("Table", _box("table", (3, 2, 0.1)), (0, 0, -0.05))
    link = _turned("link", _LINK, 32)
    for chain in range(8):
        before: Object | None = None
        for k in range(8):
            name = f"arm{chain}_link{k}"
            obj = _object(name, link, (0.33 * chain - 1.15, 0, 0) if k == 0 else (0, 0, 0.3))
            obj.parent, before = before, obj
            if k == 0:
                continue
            for frame in (1, FRAMES // 2, FRAMES):
                turn = 0.15 * np.sin(chain + k + frame)
                obj.rotation_euler = turn, turn / 2, 0
                obj.keyframe_insert("rotation_euler", frame=frame)


def walker() -> None:
    """A skinned character of 20,000 vertices that swings its legs on a floor."""
    _object("Floor", _box("floor", (6, 6, 0.2)), (0, 0, -0.1))
    scene = bpy.context.scene
    armature, body = add_character(scene, "Walker", standing(_HANGING))
    while len(body.data.vertices) < 15_000:
        _subdivide(body)
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        bone = armature.pose.bones[f"mixamorig:{side}UpLeg"]
        bone.rotation_mode = "XYZ"
        for frame in (1, 16, 31, 46, FRAMES):
            bone.rotation_euler.x = sign * 0.4 * np.cos(2 * np.pi * (frame - 1) / 30)
            bone.keyframe_insert("rotation_euler", frame=frame)
    low = min((body.matrix_world @ vertex.co).z for vertex in body.data.vertices)
    armature.location.z -= low


def _subdivide(obj: Object) -> None:
    import bmesh

    work = bmesh.new()
    work.from_mesh(obj.data)
    bmesh.ops.subdivide_edges(work, edges=work.edges, cuts=1, use_grid_fill=True)
    work.to_mesh(obj.data)
    work.free()


def pile() -> None:
    """40 rings of shape *Mesh* that fall onto each other."""
    scene = bpy.context.scene
    bpy.ops.rigidbody.world_add()
    world = scene.rigidbody_world
    world.collection = bpy.data.collections.new("bodies")
    world.point_cache.frame_end = FRAMES
    ground = _object("Ground", _box("ground", (8, 8, 0.4)), (0, 0, -0.2))
    ring, random = _turned("ring", _RING, 28, True), np.random.default_rng(40)
    rings = []
    for k in range(40):
        layer, number = divmod(k, 4)
        place = 0.4 * (number % 2), 0.4 * (number // 2), 0.4 + 0.3 * layer
        rings.append(_object(f"Ring.{k:03d}", ring, place))
        rings[-1].rotation_euler = random.uniform(-0.4, 0.4, 3)
    for obj in (ground, *rings):
        world.collection.objects.link(obj)
        obj.rigid_body.type = "PASSIVE" if obj is ground else "ACTIVE"
        obj.rigid_body.collision_shape = "BOX" if obj is ground else "MESH"


def city() -> None:
    """2,000 buildings of concave outlines on a ground, and a tram."""
    _object("Ground", _box("ground", (1000, 1000, 2)), (0, 0, -1))
    court = _turned("court", ((6, 0), (6, 20), (4, 20), (4, 0)), 8, True)
    for k in range(1998):
        _object(f"Building.{k:04d}", court, (20 * (k % 45) - 440, 20 * (k // 45) - 440, 0))
    _moved(_object("Tram", _box("tram", (2, 12, 3)), (10, -400, 1.5)), (0, 200, 0))


def house() -> None:
    """134 objects: rooms with walls around air, slabs, and a lamp in each, and one who walks."""
    room = _turned("room", ((2.1, 0), (2.1, 2.6), (2, 2.6), (2, 0)), 4, True)
    slab, lamp = _box("slab", (13, 13, 0.2)), _turned("lamp", _BOWL)
    for floor in range(4):
        _object(f"Slab.{floor:03d}", slab, (0, 0, 2.8 * floor - 0.1))
        for k in range(16):
            place = 3.1 * (k % 4) - 4.65, 3.1 * (k // 4) - 4.65, 2.8 * floor
            _object(f"Room.{floor}{k:02d}", room, place)
            _object(f"Lamp.{floor}{k:02d}", lamp, (place[0], place[1], place[2] + 1.5))
    _object("Roof", slab, (0, 0, 11.1))
    _moved(_object("Walker", _box("walker", (0.4, 0.4, 1.8)), (-4.65, -4.65, 0.9)), (1, 0, 0))


SCENES: dict[str, Callable[[], None]] = {
    scene.__name__: scene for scene in (kitchen, robots, walker, pile, city, house)
}


def build(name: str) -> tuple[Scene, list[Object]]:
    """A new file with one of the scenes, nothing of it haptic; the objects with surfaces."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, FRAMES
    SCENES[name]()
    bpy.context.view_layer.update()
    return scene, [obj for obj in scene.objects if obj.type == "MESH"]
