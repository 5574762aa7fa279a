"""A dishwasher felt at the kitchen table: through cupboard, floor and chair, past its own rubber
feet."""

from __future__ import annotations

import math
from itertools import pairwise

from bpy.types import Material, Object, Scene
from mathutils import Vector

from .avatar import Hand, build_avatar, seated
from .furniture import add_chair, add_table
from .geometry import SUNK, Point, box, cylinder, joined, lathe, rod
from .lighting import (
    add_area_light,
    add_backdrop,
    add_camera,
    add_three_point_light,
    add_world,
    set_picture,
)
from .materials import CERAMIC, CONCRETE, HARDWOOD, RUBBER, STEEL, STONE, isolate, surface
from .staging import add_rigid_body_world, make_source, make_static, place

FRAMES = 96
FLOOR = (3.9, 3.0, 0.15)
CHAIR: Point = (0.25, 0.02, 0.0)
CHAIR_HEIGHT, LEAN = 0.45, math.radians(8)
TABLE_HEIGHT = 0.74
ROW = 1.12  # y of the middle of the kitchen units
UNIT = (0.60, 0.56, 0.84)  # a cupboard
FEET = 0.06  # height of the dishwasher's feet


def build(scene: Scene) -> None:
    """Fill the empty ``scene``."""
    set_picture(scene, FRAMES)
    add_rigid_body_world(scene, FRAMES)
    white = surface("Lacquer", "#e6e3da", 0.35)
    steel = surface("Brushed Steel", "#9aa0a5", 0.35, 1.0)
    _add_floor(scene)
    _add_kitchen_units(scene, white, steel)
    _add_dishwasher(scene, steel)
    isolate(scene, RUBBER, 14.5)
    beech, dark = (
        surface("Beech", "#c99a66", 0.5, mottle=0.25, mottle_scale=9.0),
        surface("Walnut", "#6a452b", 0.5, mottle=0.25),
    )
    add_chair(scene, CHAIR, beech, heading=0.0, height=CHAIR_HEIGHT, lean=LEAN)
    add_table(
        scene,
        "Table",
        (CHAIR[0], CHAIR[1] - 0.74, 0.0),
        beech,
        dark,
        size=(1.15, 0.70),
        height=TABLE_HEIGHT,
    )
    on_table = Hand(Vector((0.20, -0.50, TABLE_HEIGHT - SUNK)), Vector((-0.25, -1.0, -0.06)))
    build_avatar(scene, seated(CHAIR_HEIGHT, LEAN, on_table), CHAIR)
    _add_tableware(scene, white)
    _add_surroundings(scene)


def _add_floor(scene: Scene) -> None:
    """Chequered tiles on one slab."""
    width, depth, height = FLOOR
    columns, rows = 13, 10
    x, y = width / columns, depth / rows
    tiles = [
        box((x - 0.006, y - 0.006, 0.02), 0.003)
        .moved((i + 0.5) * x - width / 2, (j + 0.5) * y - depth / 2, -0.01)
        .painted((i + j) % 2)
        for i in range(columns)
        for j in range(rows)
    ]
    slab = box((width, depth, height - 0.006)).moved(z=-(height + 0.006) / 2).painted(2)
    materials = (
        surface("Tile Light", "#b7b3a6", 0.3),
        surface("Tile Dark", "#6f7d82", 0.3),
        surface("Screed", "#6a6660", 0.9),
    )
    make_static(scene, place(scene, "Floor", joined([*tiles, slab]), materials), CONCRETE, "BOX")


def _add_kitchen_units(scene: Scene, white: Material, steel: Material) -> None:
    """Two cupboards on the floor, a gap for the dishwasher between them, a stone worktop across."""
    blue = surface("Cupboard Blue", "#5f7f93", 0.45)
    width, depth, height = UNIT
    for x, name in ((-width, "Cupboard Left"), (width, "Cupboard Right")):
        body = box((width, depth, height - 0.08), 0.004).moved(z=0.08 + (height - 0.08) / 2)
        plinth = box((width, depth - 0.06, 0.10)).moved(0.0, 0.03, 0.05).painted(2)
        door = box((width - 0.012, 0.018, height - 0.10), 0.005).moved(
            0.0, -(depth + 0.018) / 2, 0.09 + (height - 0.10) / 2
        )
        handle = rod(
            (0.20, -depth / 2 - 0.045, 0.52), (0.20, -depth / 2 - 0.045, 0.72), 0.007
        ).painted(1)
        posts = [
            rod((0.20, -depth / 2 - 0.045, z), (0.20, -depth / 2 - 0.01, z), 0.005).painted(1)
            for z in (0.54, 0.70)
        ]
        cupboard = place(
            scene,
            name,
            joined([body, plinth, door, handle, *posts]),
            (blue, steel, white),
            (x, ROW, -SUNK),
        )
        make_static(scene, cupboard, HARDWOOD)
    worktop = box((3 * width + 0.04, depth + 0.06, 0.04), 0.006).moved(z=0.02)
    stone = surface("Worktop", "#4f5356", 0.25, mottle=0.4, mottle_scale=40.0)
    make_static(
        scene,
        place(scene, "Worktop", worktop, (stone,), (0.0, ROW - 0.02, height - 2 * SUNK)),
        STONE,
        "BOX",
    )


def _add_dishwasher(scene: Scene, steel: Material) -> Object:
    """The blades of its pump pass 150 times a second; it stands on rubber and is clamped between
    the cupboards."""
    width, depth = UNIT[0] + 2 * SUNK, UNIT[1]
    height = UNIT[2] - FEET - 0.03
    dark, light = (
        surface("Dishwasher Panel", "#2b2f33", 0.3),
        surface("Display", "#58d6a0", 0.4, glow=2.0),
    )
    body = box((width, depth, height), 0.006).moved(z=height / 2)
    door = box((width - 0.016, 0.03, height - 0.16), 0.006).moved(
        0.0, -(depth + 0.03) / 2, (height - 0.16) / 2 + 0.02
    )
    panel = (
        box((width - 0.016, 0.03, 0.11), 0.006)
        .moved(0.0, -(depth + 0.03) / 2, height - 0.065)
        .painted(1)
    )
    handle = rod(
        (-0.20, -depth / 2 - 0.055, height - 0.16), (0.20, -depth / 2 - 0.055, height - 0.16), 0.010
    )
    ends = [
        rod((x, -depth / 2 - 0.055, height - 0.16), (x, -depth / 2, height - 0.16), 0.008)
        for x in (-0.18, 0.18)
    ]
    display = box((0.07, 0.004, 0.025)).moved(0.12, -depth / 2 - 0.032, height - 0.065).painted(2)
    knob = (
        cylinder(0.02, 0.02, 20, 0.004)
        .turned(math.pi / 2, "X")
        .moved(-0.15, -depth / 2 - 0.038, height - 0.065)
    )
    shape = joined([body, door, panel, handle, *ends, display, knob])
    machine = place(scene, "Dishwasher", shape, (steel, dark, light), (0.0, ROW, FEET))
    make_static(scene, machine, STEEL)
    foot = lathe(((0.026, -SUNK), (0.026, 0.02), (0.015, 0.025), (0.015, FEET + SUNK)), 16)
    rubber = surface("Rubber", "#1d1d1f", 0.85)
    for x, side in ((0.24, "L"), (-0.24, "R")):
        for y, end in ((-0.22, "Front"), (0.22, "Back")):
            name = f"Dishwasher Foot {end}.{side}"
            make_static(scene, place(scene, name, foot, (rubber,), (x, ROW + y, 0.0)), RUBBER)
    return make_source(machine, "SINE", 150.0)


def _add_tableware(scene: Scene, white: Material) -> None:
    """A cup that stands on the table is haptic, too; the rest is not."""
    cup = lathe(
        ((0.026, 0.0), (0.036, 0.01), (0.040, 0.085), (0.037, 0.085), (0.033, 0.015), (0.0, 0.012)),
        24,
    )
    ring = [rod(a, b, 0.005, 8) for a, b in _handle_chords()]
    china = surface("Red China", "#b5402f", 0.25)
    at_hand = (CHAIR[0] - 0.08, CHAIR[1] - 0.80, TABLE_HEIGHT - SUNK)
    make_static(
        scene,
        place(scene, "Cup", joined([cup, *ring]), (china,), at_hand, (0.0, 0.0, 0.6)),
        CERAMIC,
    )
    plate = lathe(((0.055, 0.0), (0.10, 0.014), (0.098, 0.018), (0.06, 0.006), (0.0, 0.006)), 32)
    place(scene, "Plate", plate, (white,), (CHAIR[0] + 0.22, CHAIR[1] - 0.86, TABLE_HEIGHT))
    top = UNIT[2] + 0.04 - 2 * SUNK
    bottle = lathe(
        ((0.036, 0.0), (0.038, 0.01), (0.038, 0.18), (0.014, 0.23), (0.014, 0.30), (0.0, 0.30)), 20
    )
    glass = surface("Green Glass", "#3f7a4f", 0.1)
    for number, (x, y) in enumerate(((-0.72, 0.10), (-0.60, 0.16)), 1):
        place(scene, f"Bottle {number}", bottle, (glass,), (x, ROW + y, top))
    stack = joined(plate.moved(z=0.012 * k) for k in range(6))
    place(scene, "Stack of Plates", stack, (white,), (-0.15, ROW + 0.02, top))
    pot = lathe(
        ((0.0, 0.0), (0.09, 0.0), (0.115, 0.19), (0.105, 0.19), (0.10, 0.17), (0.0, 0.165)), 24
    )
    place(
        scene, "Flower Pot", pot, (surface("Terracotta", "#b0623f", 0.8),), (0.66, ROW + 0.08, top)
    )
    leaves = [
        rod(
            (0.0, 0.0, 0.15),
            (0.13 * math.cos(a), 0.13 * math.sin(a), 0.36 + 0.05 * (k % 3)),
            0.012,
            6,
        )
        for k, a in _around(9)
    ]
    place(
        scene, "Plant", joined(leaves), (surface("Leaf", "#4f8a3f", 0.7),), (0.66, ROW + 0.08, top)
    )


def _around(count: int) -> list[tuple[int, float]]:
    """Numbers and angles of ``count`` things in a ring."""
    return [(k, 2 * math.pi * k / count) for k in range(count)]


def _handle_chords() -> list[tuple[Point, Point]]:
    """Half a ring beside the cup, in straight pieces."""
    points = [
        (0.036 + 0.028 * math.sin(math.pi * k / 6), 0.0, 0.045 - 0.026 * math.cos(math.pi * k / 6))
        for k in range(7)
    ]
    return list(pairwise(points))


def _add_surroundings(scene: Scene) -> Object:
    wall = box((FLOOR[0], 0.08, 2.1), 0.01).moved(0.0, FLOOR[1] / 2 - 0.04, 1.05)
    place(scene, "Wall", wall, (surface("Wall Paint", "#a8b59f", 0.9),))
    tiles = [
        box((0.145, 0.01, 0.095), 0.003).moved(
            0.15 * i - 0.825, FLOOR[1] / 2 - 0.084, 0.945 + 0.1 * j
        )
        for i in range(12)
        for j in range(4)
    ]
    place(scene, "Wall Tiles", joined(tiles), (surface("Glaze", "#d9d6c6", 0.2),))
    add_backdrop(scene, surface("Backdrop", "#7b7f86", 0.95), 30.0, -9.0, 6.0, -FLOOR[2], 7.0)
    add_world(scene, "#cdd3da", 0.3)
    add_three_point_light(scene, (0.0, 0.1, 0.7), 3.4)
    add_area_light(scene, "Lamp Light", (0.1, 0.5, 2.9), (0.1, 0.3, 0.0), 60.0, 0.7, "#ffe6c4")
    return add_camera(scene, (-2.35, -4.9, 2.35), (0.02, 0.15, 0.62), 40.0)
