"""A fire felt in an armchair, through the air: a persistent source that crackles, now more, now
less."""

from __future__ import annotations

import math
from itertools import pairwise
from random import Random

from bpy.types import Object, Scene
from mathutils import Vector

from .animation import animate
from .avatar import build_avatar, seated
from .furniture import add_armchair
from .geometry import SUNK, Geometry, box, joined, lathe, limb, rod, superellipsoid
from .lighting import (
    add_area_light,
    add_backdrop,
    add_camera,
    add_point_light,
    add_world,
    set_picture,
)
from .materials import HARDWOOD, STONE, surface
from .staging import add_rigid_body_world, make_medium, make_source, make_static, place

FRAMES = 120
CHAIR_HEIGHT, LEAN = 0.42, math.radians(12)
FIRE = Vector((-1.02, 0.0, 0.0))
AIR_FADES = 0.6  # per metre


def build(scene: Scene) -> None:
    """Fill the empty ``scene``."""
    set_picture(scene, FRAMES)
    add_rigid_body_world(scene, FRAMES)
    boards = (
        surface("Floor Boards", "#8a5f3c", 0.45, mottle=0.3),
        surface("Joists", "#3e2f25", 0.8),
    )
    make_static(scene, place(scene, "Floor", _floor(), boards), HARDWOOD, "BOX")
    _add_fireplace(scene)
    _add_fire(scene)
    cloth, wood = (
        surface("Green Cloth", "#4d6b57", 0.9, mottle=0.15, mottle_scale=30.0),
        surface("Dark Wood", "#3f2718", 0.4),
    )
    place_of_chair = (0.98, 0.0, 0.0)
    add_armchair(
        scene, place_of_chair, cloth, wood, heading=-math.pi / 2, height=CHAIR_HEIGHT, lean=LEAN
    )
    build_avatar(scene, seated(CHAIR_HEIGHT, LEAN), place_of_chair, -math.pi / 2)
    air = place(
        scene, "Air", box((2.5, 1.5, 1.75)).moved(-0.05, 0.0, 0.92), (surface("Air", "#9fc4e8"),)
    )
    make_medium(air, AIR_FADES)
    _add_surroundings(scene)


def _floor() -> Geometry:
    width, depth = 3.7, 2.4
    boards = [
        box((width, 0.196, 0.03), 0.004).moved(0.0, (k + 0.5) * 0.2 - depth / 2, -0.015)
        for k in range(12)
    ]
    return joined([*boards, box((width, depth, 0.12)).moved(z=-0.09).painted(1)])


def _add_fireplace(scene: Scene) -> None:
    """A hearth, two pillars, a lintel with a shelf and a chimney, all of stone; each stands on the
    one below."""
    stone, pale = (
        surface("Brick", "#8c5646", 0.85, mottle=0.35, mottle_scale=8.0),
        surface("Sandstone", "#c8b79a", 0.7, mottle=0.2),
    )
    hearth = place(
        scene,
        "Hearth",
        box((0.95, 1.75, 0.08), 0.012).moved(z=0.04 - SUNK),
        (pale,),
        (FIRE.x - 0.14, 0.0, 0.0),
    )
    make_static(scene, hearth, STONE, "BOX")
    for y, side in ((0.58, "L"), (-0.58, "R")):
        pillar = place(
            scene,
            f"Pillar.{side}",
            _bricks(0.40, 0.34, 0.84),
            (stone, pale),
            (FIRE.x - 0.30, y, 0.08 - 2 * SUNK),
        )
        make_static(scene, pillar, STONE, "BOX")
    lintel = place(
        scene,
        "Lintel",
        box((0.52, 1.66, 0.14), 0.015).moved(z=0.07),
        (pale,),
        (FIRE.x - 0.29, 0.0, 0.92 - 3 * SUNK),
    )
    make_static(scene, lintel, STONE, "BOX")
    chimney = place(
        scene,
        "Chimney",
        _bricks(0.42, 1.30, 0.76),
        (stone, pale),
        (FIRE.x - 0.31, 0.0, 1.06 - 4 * SUNK),
    )
    make_static(scene, chimney, STONE, "BOX")
    soot = surface("Soot", "#171310", 0.95)
    place(
        scene, "Fireback", box((0.02, 0.84, 0.86)).moved(z=0.50), (soot,), (FIRE.x - 0.46, 0.0, 0.0)
    )


def _bricks(depth: float, width: float, height: float) -> Geometry:
    """A wall of courses that are set off from each other; it stands on z = 0."""
    count = round(height / 0.085)
    course = height / count
    bricks = [box((depth - 0.012, width - 0.012, height)).moved(z=height / 2)]
    for k in range(count):
        half = 0.105 if k % 2 else 0.0
        edges = sorted(
            {
                -width / 2,
                width / 2,
                *(
                    min(max(half - width / 2 + 0.21 * n, -width / 2), width / 2)
                    for n in range(1, 8)
                ),
            }
        )
        for low, high in pairwise(edges):
            if high - low > 0.03:
                bricks.append(
                    box((depth, high - low - 0.008, course - 0.008), 0.006).moved(
                        0.0, (low + high) / 2, (k + 0.5) * course
                    )
                )
    return joined(bricks)


def _add_fire(scene: Scene) -> None:
    """Logs on the hearth, which are the source; flames, nothing haptic, that flicker."""
    bark, ember = (
        surface("Bark", "#4a3325", 0.9, mottle=0.4, mottle_scale=20.0),
        surface("Ember", "#ff6a1f", 0.8, glow=6.0),
    )
    low = 0.08 + 0.055
    logs = [
        rod((0.06, -0.26, low), (0.02, 0.26, low), 0.055, 14),
        rod((-0.10, -0.25, low), (-0.14, 0.24, low), 0.055, 14),
        rod((-0.02, -0.20, low + 0.095), (-0.07, 0.22, low + 0.095), 0.05, 14),
        superellipsoid((0.16, 0.36, 0.06), 0.8, 16, 8).moved(-0.04, 0.0, 0.105).painted(1),
    ]
    fire = place(scene, "Fire", joined(logs).moved(z=-SUNK), (bark, ember), FIRE)
    make_static(scene, fire, HARDWOOD)
    make_source(fire, "NOISE")
    draw = Random(3)
    strength = {float(frame): 0.75 + 0.25 * draw.random() for frame in range(1, FRAMES + 1, 6)}
    animate(fire, "haptics.source.amplitude", strength)
    flame_materials = (
        surface("Flame Outer", "#ff4a00", 0.9, glow=1.1),
        surface("Flame Inner", "#ffa51e", 0.9, glow=2.2),
    )
    for number in range(7):
        height = draw.uniform(0.20, 0.40)
        tongue = limb(height, 0.055, 0.006).painted(0) + limb(0.6 * height, 0.032, 0.005).moved(
            0.035, 0.0, 0.0
        ).painted(1)
        spot = (FIRE.x + draw.uniform(-0.10, 0.06), -0.21 + 0.07 * number, 0.15)
        flame = place(scene, f"Flame {number + 1}", tongue, flame_materials, spot)
        flame.visible_shadow = False
        animate(
            flame,
            "scale",
            {
                float(frame): (1.0, 1.0, draw.uniform(0.75, 1.2))
                for frame in range(1, FRAMES + 1, 4)
            },
        )
    glow = add_point_light(scene, "Fire Light", (FIRE.x + 0.12, 0.0, 0.42), 45.0, 0.15, "#ff9a4a")
    animate(glow.data, "energy", {frame: 50.0 * value for frame, value in strength.items()})


def _add_surroundings(scene: Scene) -> Object:
    rug = lathe(((0.70, 0.0), (0.70, 0.012), (0.55, 0.0121), (0.50, 0.0121)), 48).painted(0)
    place(
        scene,
        "Rug",
        rug,
        (surface("Rug", "#7c3b35", 0.95, mottle=0.2, mottle_scale=40.0),),
        (0.22, -0.15, 0.0),
    )
    add_backdrop(scene, surface("Backdrop", "#4a4550", 0.95), 30.0, -9.0, 6.0, -0.15, 7.0)
    add_world(scene, "#8f9ab5", 0.18)
    add_area_light(scene, "Window Light", (2.2, -3.6, 3.2), (0.1, 0.0, 0.6), 150.0, 1.6, "#dfe6ff")
    add_area_light(scene, "Rim Light", (1.8, 3.2, 2.8), (0.3, 0.0, 0.8), 130.0, 1.4, "#ffe3c4")
    return add_camera(scene, (1.75, -5.1, 1.9), (-0.16, 0.0, 0.76), 42.0)
