"""A pile of things in a crate on a shaking table: as many contacts as wanted."""

from __future__ import annotations

import math
from itertools import pairwise
from random import Random

from bpy.types import Mesh, Object, Scene
from mathutils import Vector

from .avatar import Hand, build_avatar, standing
from .geometry import SUNK, Geometry, box, cylinder, joined, lathe, rod, sphere, to_mesh
from .lighting import add_backdrop, add_camera, add_three_point_light, add_world, set_picture
from .materials import CONCRETE, SOFTWOOD, STEEL, surface
from .staging import add_rigid_body_world, make_dynamic, make_source, make_static, place, place_mesh

COUNT = 200
FRAMES = 150
LEAST_SIDE = 1.10  # of the tray inside, which grows with the number of things
FRONT, HEIGHT = 0.36, 0.60  # of the tray's walls
TABLE_HEIGHT = 0.42
SPRING_LENGTH = TABLE_HEIGHT - 0.06 + 2 * SUNK
WALL = 0.035
PITCH = 0.185  # between falling things
SIZE = 0.13


def build(scene: Scene, count: int = COUNT) -> None:
    """Fill the empty ``scene`` with ``count`` things that fall into a tray."""
    set_picture(scene, FRAMES)
    add_rigid_body_world(scene, FRAMES)
    side = LEAST_SIDE * max(1.0, math.sqrt(count / COUNT))
    slab = box((side + 3.0, side + 2.3, 0.12), 0.02).moved(z=-0.06)
    floor = place(scene, "Floor", slab, (surface("Screed", "#85878a", 0.7, mottle=0.15),))
    make_static(scene, floor, CONCRETE, "BOX")
    _add_shaking_table(scene, side + 2 * WALL + 0.10)
    _add_tray(scene, side)
    _add_things(scene, count, side)
    edge = TABLE_HEIGHT + HEIGHT + WALL
    palm = Hand(Vector((0.20, -0.30, edge - 2 * SUNK)), Vector((0.0, -1.0, -0.02)))
    build_avatar(scene, standing(palm), (0.0, side / 2 + WALL / 2 + 0.30, 0.0))
    _add_surroundings(scene, side / LEAST_SIDE)


def _add_shaking_table(scene: Scene, side: float) -> Object:
    """A motor below a plate on four springs, at 100 Hz: the source."""
    steel, blue = (
        surface("Bare Steel", "#9a9fa4", 0.3, 1.0),
        surface("Machine Blue", "#2f5d8a", 0.4),
    )
    black = surface("Rubber", "#1d1d1f", 0.85)
    plate = box((side, side, 0.06), 0.01).moved(z=TABLE_HEIGHT - 0.03)
    motor = (
        cylinder(0.13, 0.36, 28, 0.02)
        .turned(math.pi / 2, "Y")
        .moved(z=TABLE_HEIGHT - 0.19)
        .painted(1)
    )
    fin = cylinder(0.145, 0.012, 28).turned(math.pi / 2, "Y").painted(1)
    fins = [fin.moved(-0.12 + 0.06 * k, 0.0, TABLE_HEIGHT - 0.19) for k in range(5)]
    table = place(
        scene, "Shaking Table", joined([plate, motor, *fins]), (steel, blue), (0.0, 0.0, 0.0)
    )
    make_static(scene, table, STEEL)
    pad, cap = (
        cylinder(0.05, 0.03, 20, 0.006).moved(z=0.015).painted(1),
        cylinder(0.05, 0.02, 20, 0.005).moved(z=SPRING_LENGTH - 0.01),
    )
    spring = joined((pad, _coil(), cap))
    offset = side / 2 - 0.09
    for x, across in ((offset, "L"), (-offset, "R")):
        for y, along in ((-offset, "Front"), (offset, "Back")):
            leg = place(scene, f"Spring {along}.{across}", spring, (steel, black), (x, y, -SUNK))
            make_static(scene, leg, STEEL)
    return make_source(table, "SINE", 100.0)


def _coil() -> Geometry:
    turns, steps, radius, low, high = 6, 12, 0.04, 0.03, SPRING_LENGTH - 0.02
    points = []
    for k in range(turns * steps + 1):
        angle = 2 * math.pi * k / steps
        points.append(
            (
                radius * math.cos(angle),
                radius * math.sin(angle),
                low + (high - low) * k / (turns * steps),
            )
        )
    return joined(rod(a, b, 0.008, 6) for a, b in pairwise(points))


def _add_tray(scene: Scene, side: float) -> None:
    """A floor and four walls, each a haptic object."""
    wood, board = (
        surface("Tray Floor", "#c7a273", 0.6, mottle=0.25, mottle_scale=8.0),
        surface("Tray Board", "#a8835a", 0.6, mottle=0.25),
    )
    outer, middle = side + 2 * WALL, (side + WALL) / 2
    low = WALL - 2 * SUNK
    parts: dict[str, tuple[Geometry, tuple[float, float, float]]] = {
        "Tray Floor": (box((outer, outer, WALL), 0.004), (0.0, 0.0, WALL / 2 - SUNK)),
        "Tray Wall Front": (box((outer, WALL, FRONT), 0.004), (0.0, -middle, low + FRONT / 2)),
        "Tray Wall Back": (box((outer, WALL, HEIGHT), 0.004), (0.0, middle, low + HEIGHT / 2)),
        "Tray Wall.L": (
            box((WALL, side + 2 * SUNK, HEIGHT), 0.004),
            (middle, 0.0, low + HEIGHT / 2),
        ),
        "Tray Wall.R": (
            box((WALL, side + 2 * SUNK, HEIGHT), 0.004),
            (-middle, 0.0, low + HEIGHT / 2),
        ),
    }
    for name, (shape, (px, py, pz)) in parts.items():
        make_static(
            scene,
            place(
                scene,
                name,
                shape,
                (wood if name == "Tray Floor" else board,),
                (px, py, TABLE_HEIGHT + pz),
            ),
            SOFTWOOD,
            "BOX",
        )


def _add_things(scene: Scene, count: int, side: float) -> None:
    """Boxes, balls, cylinders and cones in layers above the tray, turned at random, the same each
    time."""
    draw = Random(5)
    kinds = _kinds()
    columns = int((side - 0.04) / PITCH)
    per_layer = columns * columns
    for number in range(count):
        layer, rest = divmod(number, per_layer)
        row, column = divmod(rest, columns)
        shift = (columns - 1) / 2
        spot = (
            (column - shift) * PITCH + draw.uniform(-0.015, 0.015),
            (row - shift) * PITCH + draw.uniform(-0.015, 0.015),
            TABLE_HEIGHT + WALL + 0.16 + layer * PITCH,
        )
        kind, shape, meshes = kinds[draw.randrange(len(kinds))]
        turn = (draw.uniform(0.0, 6.28), draw.uniform(0.0, 6.28), draw.uniform(0.0, 6.28))
        thing = place_mesh(
            scene, f"{kind} {number + 1:04d}", meshes[draw.randrange(len(meshes))], spot, turn
        )
        make_dynamic(scene, thing, SOFTWOOD, 0.6, shape, friction=0.5, restitution=0.1)


def _kinds() -> list[tuple[str, str, list[Mesh]]]:
    """Name, collision shape and the meshes of each kind of thing."""
    colours = {
        "Coral": "#e0705a",
        "Sand": "#e3b15f",
        "Sage": "#7fa36a",
        "Sea": "#4f8fa8",
        "Plum": "#84648f",
    }
    paints = [surface(f"Paint {name}", code, 0.35) for name, code in colours.items()]
    half = SIZE / 2
    shapes = (
        ("Box", "BOX", box((SIZE, SIZE * 0.8, SIZE * 0.6), 0.006)),
        ("Ball", "SPHERE", sphere(half, 24, 14)),
        ("Cylinder", "CYLINDER", cylinder(half * 0.75, SIZE, 24, 0.004)),
        ("Cone", "CONE", lathe(((half, -half), (0.0, half)), 24)),
    )
    return [
        (name, shape, [to_mesh(f"{name} {paint.name}", geometry, (paint,)) for paint in paints])
        for name, shape, geometry in shapes
    ]


def _add_surroundings(scene: Scene, scale: float) -> Object:
    add_backdrop(
        scene,
        surface("Backdrop", "#59616b", 0.95),
        30.0 * scale,
        -9.0 * scale,
        6.5 * scale,
        -0.12,
        7.0 * scale,
    )
    add_world(scene, "#c3cad6", 0.3)
    add_three_point_light(scene, (0.0, 0.1, 0.8), 3.2 * scale)
    return add_camera(
        scene, (-1.6 * scale, -4.0 * scale, 0.3 + 2.9 * scale), (0.03, 0.12 * scale, 0.78), 40.0
    )
