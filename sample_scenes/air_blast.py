"""An explosion felt through the air: a source that plays once, whose pressure spreads as a front in
a medium."""

from __future__ import annotations

import math
from random import Random

from bpy.types import Object, Scene
from mathutils import Vector

from .animation import CONSTANT, animate
from .avatar import Hand, build_avatar, standing
from .crates import crate_materials, crate_shape
from .explosion import add_explosion, add_shock_ring
from .geometry import SUNK, box, cylinder, joined, lathe, superellipsoid
from .lighting import add_area_light, add_backdrop, add_camera, add_sun, add_world, set_picture
from .materials import SOFTWOOD, SOIL, STEEL, surface
from .staging import (
    add_rigid_body_world,
    make_blast,
    make_dynamic,
    make_medium,
    make_static,
    place,
    place_empty,
    spread_as_front,
)

FRAMES = 96
EXPLOSION = 30  # frame
BLAST = Vector((-3.2, 0.2, 0.45))
AVATAR = (1.9, 0.0, 0.0)
# Radius and height.
BARREL = (
    *((0.0, 0.0), (0.275, 0.0), (0.285, 0.012), (0.285, 0.03), (0.272, 0.04)),
    *((0.272, 0.28), (0.285, 0.295), (0.285, 0.315), (0.272, 0.33)),
    *((0.272, 0.57), (0.285, 0.585), (0.285, 0.605), (0.272, 0.62)),
    *((0.272, 0.85), (0.285, 0.86), (0.285, 0.885), (0.25, 0.885), (0.25, 0.87), (0.0, 0.87)),
)
FIREBALL = 2.0  # metres that the blast itself fills
OVERPRESSURE = 0.005  # seconds
AIR_ABOVE_GROUND = 0.014  # larger than the tolerance of contacts
SPEED_OF_SOUND = 343.0


def build(scene: Scene) -> None:
    """Fill the empty ``scene``."""
    set_picture(scene, FRAMES)
    add_rigid_body_world(scene, FRAMES)
    sand = surface("Sand", "#b39a74", 0.95, mottle=0.3, mottle_scale=3.0)
    ground = place(scene, "Ground", box((9.6, 5.2, 0.3), 0.05).moved(z=-0.15), (sand,))
    make_static(scene, ground, SOIL, "BOX")
    _add_barrels(scene)
    add_explosion(scene, BLAST, EXPLOSION)
    add_shock_ring(scene, (BLAST.x, BLAST.y, 0.06), EXPLOSION, 5.2)
    hands = Hand(Vector((0.30, -0.06, 0.86)), Vector((0.10, -0.25, -1.0)), Vector((1.0, 0.0, 0.0)))
    build_avatar(scene, standing(hands), AVATAR)
    _add_wall(scene)
    air = place(
        scene,
        "Air",
        box((9.0, 4.6, 2.6)).moved(0.0, 0.0, 1.3 + AIR_ABOVE_GROUND),
        (surface("Air", "#9fc4e8"),),
    )
    spread_as_front(make_medium(air, 0.0), FIREBALL, SPEED_OF_SOUND)
    make_blast(place_empty(scene, "Blast", BLAST - air.location, air), EXPLOSION, OVERPRESSURE)
    _add_surroundings(scene)


def _add_barrels(scene: Scene) -> None:
    """Steel barrels. The red one blows up; its bottom stays."""
    white = surface("Barrel Label", "#e9e4d4", 0.5)
    red, green = (
        surface("Barrel Red", "#b3261e", 0.35, 0.3),
        surface("Barrel Green", "#3f6f5a", 0.4, 0.3),
    )
    label = cylinder(0.276, 0.16, 32).moved(z=0.45).painted(1)
    barrel = joined((lathe(BARREL, 32), label))
    blown_up = place(scene, "Explosive Barrel", barrel, (red, white), (BLAST.x, BLAST.y, 0.02))
    for shown in ("hide_viewport", "hide_render"):
        animate(blown_up, shown, {1.0: 0.0, EXPLOSION + 2.0: 1.0}, CONSTANT)
    soot = surface("Soot", "#2a2725", 0.8, 0.3)
    bottom = place(
        scene,
        "Barrel Bottom",
        cylinder(0.285, 0.03, 32, 0.006),
        (soot,),
        (BLAST.x, BLAST.y, 0.015 - SUNK),
    )
    make_static(scene, bottom, STEEL, "CYLINDER")
    for number, (x, y) in enumerate(((-2.2, 1.5), (-4.1, -1.0)), 1):
        other = place(scene, f"Barrel {number}", barrel, (green, white), (x, y, -SUNK))
        make_static(scene, other, STEEL, "CYLINDER")


def _add_wall(scene: Scene) -> None:
    """A wall of planks behind the avatar, sandbags before it, crates that stand about: all haptic
    but the sandbags."""
    wood = surface("Planks", "#8b6b48", 0.8, mottle=0.35, mottle_scale=6.0)
    planks = [
        box((0.24, 0.05, 1.7 + 0.06 * (k % 3)), 0.008).moved(
            0.25 * k - 1.5, 0.0, 0.85 + 0.03 * (k % 3)
        )
        for k in range(13)
    ]
    bars = [box((3.3, 0.05, 0.10), 0.006).moved(0.0, 0.048, z) for z in (0.45, 1.35)]
    fence = place(scene, "Fence", joined([*planks, *bars]), (wood,), (2.6, 1.7, -SUNK))
    make_static(scene, fence, SOFTWOOD)
    sand = surface("Sandbag", "#8f8465", 0.95, mottle=0.3, mottle_scale=20.0)
    bag = superellipsoid((0.56, 0.30, 0.19), 0.7, 18, 10)
    spots = [
        (0.54 * i + 0.27 * (j % 2) - 1.35, 0.0, 0.09 + 0.165 * j)
        for j in range(3)
        for i in range(6 - j)
    ]
    place(
        scene,
        "Sandbags",
        joined(bag.moved(*spot) for spot in spots),
        (sand,),
        (-0.5, -1.75, 0.0),
        (0.0, 0.0, math.radians(5)),
    )
    materials = crate_materials()
    for number, (x, y, z, edge, turn) in enumerate(
        ((-0.2, 1.3, 0.0, 0.5, 8), (-0.1, 1.25, 0.5, 0.36, 30), (3.6, 0.3, 0.0, 0.55, -12)), 1
    ):
        crate = place(
            scene,
            f"Crate {number}",
            crate_shape(edge),
            materials,
            (x, y, z + edge / 2),
            (0.0, 0.0, math.radians(turn)),
        )
        make_dynamic(scene, crate, SOFTWOOD, 6.0, "BOX")


def _add_surroundings(scene: Scene) -> Object:
    draw = Random(2)
    rocks = []
    for _ in range(26):
        size = draw.uniform(0.06, 0.22)
        rock = superellipsoid((size, size * 0.8, size * 0.5), 0.7, 8, 5).turned(
            draw.uniform(0, 6), "Z"
        )
        rocks.append(
            rock.moved(draw.uniform(-4.5, 4.5), draw.choice((-1, 1)) * draw.uniform(1.6, 2.4), 0.0)
        )
    place(scene, "Rocks", joined(rocks), (surface("Rock", "#857863", 0.95),))
    add_backdrop(scene, surface("Backdrop", "#a3968c", 0.95), 60.0, -16.0, 9.0, -0.3, 10.0)
    add_world(scene, "#b9c3d4", 0.3)
    add_sun(scene, "Sun", (0.5, 0.6, -0.7), 2.6, "#ffe6c4")
    add_area_light(scene, "Fill Light", (4.5, -6.0, 4.0), (1.0, 0.0, 0.8), 260.0, 3.0, "#dfe6ff")
    return add_camera(scene, (1.5, -9.8, 3.1), (-0.25, 0.0, 0.72), 40.0)
