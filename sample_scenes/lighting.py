"""Light, camera and picture settings."""

from __future__ import annotations

import math

import bpy
from bpy.types import Camera, Light, Material, Object, Scene
from mathutils import Vector

from ..addon.blender.compatibility import eevee_engine
from .geometry import Geometry, Point
from .materials import linear_colour, node_tree
from .staging import place


def set_picture(scene: Scene, frames: int, fps: int = 24) -> None:
    """1280 x 720, ``frames`` frames from 1 on at ``fps``; quick but clean renders with EEVEE and
    Cycles."""
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = 1280, 720, 100
    render.fps, render.fps_base = fps, 1.0
    render.engine = eevee_engine()
    scene.frame_start, scene.frame_end = 1, frames
    scene.unit_settings.system = "METRIC"
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Medium High Contrast"
    if hasattr(scene, "cycles"):
        scene.cycles.samples = 32
        scene.cycles.use_denoising = True
        scene.cycles.device = "CPU"


def add_world(scene: Scene, colour: str, strength: float = 0.5) -> None:
    """An even light from all around."""
    world = bpy.data.worlds.new(f"{scene.name} World")
    background = next(
        node for node in node_tree(world).nodes if node.bl_idname == "ShaderNodeBackground"
    )
    background.inputs["Color"].default_value = linear_colour(colour)
    background.inputs["Strength"].default_value = strength
    world.color = linear_colour(colour)[:3]
    scene.world = world


def aim(obj: Object, target: Point | Vector) -> None:
    """Turn a camera or light to ``target``."""
    obj.rotation_euler = (Vector(target) - obj.location).to_track_quat("-Z", "Y").to_euler()


def add_area_light(
    scene: Scene,
    name: str,
    location: Point,
    target: Point,
    power: float,
    size: float,
    colour: str = "#ffffff",
) -> Object:
    """A square soft light of ``power`` watts."""
    light: Light = bpy.data.lights.new(name, "AREA")
    light.energy = power
    light.size = size
    light.color = linear_colour(colour)[:3]
    return _placed(scene, name, light, location, target)


def add_sun(
    scene: Scene, name: str, direction: Point, strength: float, colour: str = "#ffffff"
) -> Object:
    """Sunlight that falls along ``direction``, in watts per square metre."""
    light: Light = bpy.data.lights.new(name, "SUN")
    light.energy = strength
    light.color = linear_colour(colour)[:3]
    light.angle = math.radians(6)
    high = Vector(direction).normalized() * -8.0
    return _placed(scene, name, light, tuple(high), (0.0, 0.0, 0.0))


def add_point_light(
    scene: Scene,
    name: str,
    location: Point,
    power: float,
    radius: float = 0.1,
    colour: str = "#ffffff",
) -> Object:
    """A lamp of ``power`` watts."""
    light: Light = bpy.data.lights.new(name, "POINT")
    light.energy = power
    light.color = linear_colour(colour)[:3]
    light.shadow_soft_size = radius
    return _placed(scene, name, light, location, None)


def add_three_point_light(
    scene: Scene, centre: Point, size: float, warm: str = "#fff0dc", cool: str = "#cfe0ff"
) -> None:
    """Key light from the upper left in front, fill from the right, rim from behind, for a set of
    ``size`` metres seen from -Y."""
    c = Vector(centre)
    key, fill, rim = (
        c + Vector(offset) * size
        for offset in ((-0.8, -0.9, 1.2), (1.3, -0.8, 0.6), (0.5, 1.3, 1.1))
    )
    power = 42.0 * size * size
    add_area_light(scene, "Key Light", tuple(key), centre, power, 0.5 * size, warm)
    add_area_light(scene, "Fill Light", tuple(fill), centre, 0.3 * power, 1.0 * size, cool)
    add_area_light(scene, "Rim Light", tuple(rim), centre, 0.7 * power, 0.5 * size, cool)


def add_camera(scene: Scene, location: Point, target: Point, lens: float = 40.0) -> Object:
    """The scene's camera; ``lens`` in millimetres over a 36 mm frame."""
    camera: Camera = bpy.data.cameras.new("Camera")
    camera.lens = lens
    camera.clip_end = 500.0
    obj = _placed(scene, "Camera", camera, location, target)
    scene.camera = obj
    return obj


def add_backdrop(
    scene: Scene,
    material: Material,
    width: float,
    front: float,
    back: float,
    floor: float,
    height: float,
) -> Object:
    """A studio background: a floor at z = ``floor`` that bends up into a wall at y = ``back``."""
    bend = min(2.0, 0.5 * height)
    profile = [(front, floor), (back - bend, floor)]
    turns = [math.pi / 2 * k / 12 for k in range(1, 13)]
    profile += [
        (back - bend + bend * math.sin(turn), floor + bend * (1 - math.cos(turn))) for turn in turns
    ]
    profile.append((back, floor + height))
    vertices = tuple((x, y, z) for y, z in profile for x in (-width / 2, width / 2))
    faces = tuple((2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2) for k in range(len(profile) - 1))
    return place(scene, "Backdrop", Geometry(vertices, faces, (0,) * len(faces)), (material,))


def _placed(
    scene: Scene, name: str, data: Light | Camera, location: Point, target: Point | None
) -> Object:
    obj = bpy.data.objects.new(name, data)
    scene.collection.objects.link(obj)
    obj.location = location
    if target is not None:
        aim(obj, target)
    return obj
