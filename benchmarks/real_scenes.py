"""Scenes of concave, skinned and many objects, as content that is imported has them: those made by
formulas, of which bowls, arms of robots and the walk are those of the samples, and two of robots
that `PYBULLET_DATA` describes."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path

import bpy
import numpy as np
from bpy.types import Mesh, Object, Scene
from haptic_tracing.sample_scenes.avatar import HANGING, standing
from haptic_tracing.sample_scenes.gait import walk
from haptic_tracing.sample_scenes.geometry import Geometry, Point, box, lathe, to_mesh
from haptic_tracing.sample_scenes.real_content import BOWL, BOWL_STEP, add_arm, add_character

from .urdf import add_robot

FRAMES = 60

_RING = (0.3, 0.0), (0.36, 0.05), (0.3, 0.1), (0.24, 0.05)


def _object(name: str, mesh: Mesh, place: Sequence[float] = (0, 0, 0)) -> Object:
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    obj.location = place
    return obj


def _box(name: str, size: Point) -> Mesh:
    return to_mesh(name, box(size), ())


def _around_hole(name: str, profile: Sequence[tuple[float, float]], sides: int) -> Mesh:
    """What a profile of (radius, z), anticlockwise, sweeps about the z axis around a hole."""
    turned, count = lathe(profile, sides), len(profile)
    last = [
        ((count - 1) * sides + k, (count - 1) * sides + (k + 1) % sides, (k + 1) % sides, k)
        for k in range(sides)
    ]
    faces = (*turned.faces[:-2], *last)
    return to_mesh(name, Geometry(turned.vertices, faces, (0,) * len(faces)), ())


def _moved(obj: Object, way: Sequence[float], frames: int = FRAMES) -> Object:
    begin = np.array(obj.location)
    for frame, share in ((1, 0.0), (frames // 2, 1.0), (frames, 0.0)):
        obj.location = begin + share * np.array(way)
        obj.keyframe_insert("location", frame=frame)
    return obj


def kitchen() -> None:
    """240 objects: a worktop with bowls in each other, shelves, a pan that is pushed along."""
    _object("Floor", _box("floor", (6, 4, 0.2)), (0, 0, -0.1))
    bowl, shelf = to_mesh("bowl", lathe(BOWL), ()), _box("shelf", (3.9, 0.5, 0.02))
    for k in range(8):
        _object(f"Shelf.{k:03d}", shelf, (0, 1.0, 0.3 * k + 0.01))
        _object(f"Side.{k:03d}", _box("side", (0.05, 0.5, 0.27)), (1.9, 1.0, 0.3 * k + 0.155))
    for k in range(222):
        level, number = divmod(k, 28)
        column, layer = divmod(number, 2)
        place = 0.26 * column - 1.82, 1.0, 0.3 * level + 0.02 + BOWL_STEP * layer
        _object(f"Bowl.{k:03d}", bowl, place)
    _moved(_object("Pan", to_mesh("pan", lathe(BOWL, 48), ()), (-1, 0, 0)), (1, 0, 0))


def robots() -> None:
    """65 links: two arms and six legs on a table, all of whose joints turn."""
    _object("Table", _box("table", (3, 2, 0.1)), (0, 0, -0.05))
    scene = bpy.context.scene
    for chain in range(8):
        place = (0.33 * chain - 1.15, 0.0, 0.0)
        for k, obj in enumerate(add_arm(scene, f"arm{chain}", (0.3,) * 8, place, ())[1:], 1):
            for frame in (1, FRAMES // 2, FRAMES):
                turn = 0.15 * np.sin(chain + k + frame)
                obj.rotation_euler = turn, turn / 2, 0
                obj.keyframe_insert("rotation_euler", frame=frame)


def walker() -> None:
    """A skinned character of 20,000 vertices that walks along a floor."""
    _object("Floor", _box("floor", (6, 6, 0.2)), (0, 0, -0.1))
    scene = bpy.context.scene
    armature, body = add_character(scene, "Walker", standing(HANGING))
    while len(body.data.vertices) < 15_000:
        _subdivide(body)
    armature.location.y = 1.2
    walk(armature, range(1, FRAMES + 1), 30.0)


def _subdivide(obj: Object) -> None:
    import bmesh

    work = bmesh.new()
    work.from_mesh(obj.data)
    bmesh.ops.subdivide_edges(work, edges=work.edges, cuts=1, use_grid_fill=True)
    work.to_mesh(obj.data)
    work.free()


def _falling(rings: int, sides: int, per_layer: int) -> None:
    """Rings of shape *Mesh* that fall onto a ground and each other, each of 8 triangles a side."""
    scene = bpy.context.scene
    bpy.ops.rigidbody.world_add()
    world = scene.rigidbody_world
    world.collection = bpy.data.collections.new("bodies")
    world.point_cache.frame_end = FRAMES
    ground = _object("Ground", _box("ground", (8, 8, 0.4)), (0, 0, -0.2))
    ring, random = _around_hole("ring", _RING, sides), np.random.default_rng(40)
    bodies = [ground]
    for k in range(rings):
        layer, number = divmod(k, per_layer)
        place = 0.4 * (number % 2), 0.4 * (number // 2), 0.4 + 0.3 * layer
        bodies.append(_object(f"Ring.{k:03d}", ring, place))
        bodies[-1].rotation_euler = random.uniform(-0.4, 0.4, 3)
    for obj in bodies:
        world.collection.objects.link(obj)
        obj.rigid_body.type = "PASSIVE" if obj is ground else "ACTIVE"
        obj.rigid_body.collision_shape = "BOX" if obj is ground else "MESH"


def pile() -> None:
    """40 rings of 224 triangles that fall onto each other."""
    _falling(40, 28, 4)


def rings() -> None:
    """Two rings of 784 triangles, of which one falls onto the other."""
    _falling(2, 98, 1)


def city() -> None:
    """2,000 buildings of concave outlines on a ground, and a tram."""
    _object("Ground", _box("ground", (1000, 1000, 2)), (0, 0, -1))
    court = _around_hole("court", ((6, 0), (6, 20), (4, 20), (4, 0)), 8)
    for k in range(1998):
        _object(f"Building.{k:04d}", court, (20 * (k % 45) - 440, 20 * (k // 45) - 440, 0))
    _moved(_object("Tram", _box("tram", (2, 12, 3)), (10, -400, 1.5)), (0, 200, 0))


def house() -> None:
    """134 objects: rooms with walls around air, slabs, and a lamp in each, and one who walks."""
    room = _around_hole("room", ((2.1, 0), (2.1, 2.6), (2, 2.6), (2, 0)), 4)
    slab, lamp = _box("slab", (13, 13, 0.2)), to_mesh("lamp", lathe(BOWL), ())
    for floor in range(4):
        _object(f"Slab.{floor:03d}", slab, (0, 0, 2.8 * floor - 0.1))
        for k in range(16):
            place = 3.1 * (k % 4) - 4.65, 3.1 * (k // 4) - 4.65, 2.8 * floor
            _object(f"Room.{floor}{k:02d}", room, place)
            _object(f"Lamp.{floor}{k:02d}", lamp, (place[0], place[1], place[2] + 1.5))
    _object("Roof", slab, (0, 0, 11.1))
    _moved(_object("Walker", _box("walker", (0.4, 0.4, 1.8)), (-4.65, -4.65, 0.9)), (1, 0, 0))


def still() -> None:
    """10,000 boxes side by side on a ground, and one that slides along a track beside them."""
    box = _still_ground()
    for x, y in _STILL:
        _object(f"Box.{x:03d}.{y:03d}", box, (x, y, 0.25))
    _slider()


def instances() -> None:
    """The same with instances of one box at the vertices of a mesh."""
    box = _still_ground()
    places = bpy.data.meshes.new("places")
    places.from_pydata([(x, y, 0.25) for x, y in _STILL], [], [])
    scattered = _object("Places", places)
    scattered.instance_type = "VERTS"
    _object("Box", box).parent = scattered
    _slider()


_STILL = [(x, y) for x in range(-50, 50) for y in range(-50, 50)]


def _still_ground() -> Mesh:
    _object("Track", _box("track", (100, 4, 2)), (0, -80, -1))
    _object("Ground", _box("ground", (120, 120, 2)), (0, 0, -1))
    return _box("box", (0.5, 0.5, 0.5))


def _slider() -> None:
    _moved(_object("Slider", _box("slider", (2, 2, 0.5)), (-20, -80, 0.25)), (40, 0, 0))


def arms(shapes: str = "collision") -> None:
    """Panda, A1 and a table of pybullet_data, whose folder ``PYBULLET_DATA`` names: no part of this
    repository."""
    folder = Path(os.environ["PYBULLET_DATA"])
    for seed, (name, height, place) in enumerate(
        (("table/table", 0.0, 0.0), ("franka_panda/panda", 0.625, 0.0), ("a1/a1", 1.0, 0.6))
    ):
        add_robot(folder / f"{name}.urdf", (place, 0, height), shapes, FRAMES, seed)


def arms_seen() -> None:
    """The same by their visual meshes, of up to 28,750 triangles."""
    arms("visual")


_ALL = kitchen, robots, walker, pile, rings, city, house, still, instances, arms, arms_seen
SCENES: dict[str, Callable[[], None]] = {scene.__name__: scene for scene in _ALL}


def build(name: str) -> tuple[Scene, list[Object]]:
    """A new file with one of the scenes, nothing of it haptic; the objects with surfaces."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, FRAMES
    SCENES[name]()
    bpy.context.view_layer.update()
    return scene, [obj for obj in scene.objects if obj.type == "MESH"]
