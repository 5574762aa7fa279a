"""The paper's first figure: a jackhammer is felt on a bench, through the ground, the bench's feet
and its seat. Crates fall beside it."""

from __future__ import annotations

import math
from random import Random

from bpy.types import Material, Object, Scene

from .avatar import TURNED_UP, build_avatar, seated
from .crates import crate_materials, crate_shape
from .furniture import add_bench
from .geometry import Point, box, cylinder, joined, lathe, prism, rod, superellipsoid
from .lighting import add_backdrop, add_camera, add_three_point_light, add_world, set_picture
from .materials import CONCRETE, SOFTWOOD, STEEL, surface
from .staging import add_rigid_body_world, make_dynamic, make_source, make_static, place

FRAMES = 120
SEAT_HEIGHT = 0.45
LEAN = math.radians(10)
GROUND = (4.95, 3.15, 0.22)
BENCH: Point = (0.28, 0.58, 0.0)
JACKHAMMER: Point = (-1.12, -0.30, -0.006)

# Edge (m), height of fall (m), mass (kg), place (x, y), turn about z (degrees): 20 to 200 J, on the
# ground between frames 12 and 40.
CRATES = (
    (0.34, 1.1, 2.2, (1.60, -0.62), 12.0),
    (0.30, 2.3, 3.0, (1.02, -1.08), -25.0),
    (0.40, 4.0, 3.2, (1.95, 0.45), 38.0),
    (0.28, 6.0, 1.0, (0.56, -1.20), 8.0),
    (0.36, 8.5, 2.4, (1.70, -0.58), -8.0),
)


def build(scene: Scene) -> None:
    """Fill the empty ``scene``."""
    set_picture(scene, FRAMES)
    add_rigid_body_world(scene, FRAMES)
    wood = surface("Bench Wood", "#b9804a", 0.55, mottle=0.35, mottle_scale=9.0)
    metal = surface("Dark Metal", "#33383d", 0.4, 0.8)
    _add_ground(scene)
    _add_jackhammer(scene, metal)
    add_bench(scene, BENCH, wood, metal, height=SEAT_HEIGHT, lean=LEAN)
    build_avatar(scene, seated(SEAT_HEIGHT, LEAN), BENCH, gain=TURNED_UP)
    _add_crates(scene)
    _add_cones(scene)
    _add_barrier(scene)
    _add_rubble(scene)
    _add_surroundings(scene)


def _add_ground(scene: Scene) -> Object:
    """A slab of pavers: one haptic object, its joints mere grooves."""
    width, depth, height = GROUND
    groove, rows, columns = 0.008, 6, 9
    body = (
        box((width, depth, height - groove), 0.02)
        .moved(z=-(height - groove) / 2 - groove)
        .painted(1)
    )
    tile_x, tile_y = width / columns, depth / rows
    tiles = [
        box((tile_x - 0.012, tile_y - 0.012, groove + 0.02), 0.006)
        .moved((i + 0.5) * tile_x - width / 2, (j + 0.5) * tile_y - depth / 2, -(groove + 0.02) / 2)
        .painted(2 if (i * 7 + j * 3) % 5 == 0 else 0)
        for i in range(columns)
        for j in range(rows)
    ]
    materials = (
        surface("Paver", "#8d8a85", 0.85, mottle=0.18),
        surface("Concrete", "#5f5c58", 0.9, mottle=0.25),
        surface("Paver Dark", "#7b7771", 0.85, mottle=0.2),
    )
    ground = place(scene, "Ground", joined([body, *tiles]), materials)
    return make_static(scene, ground, CONCRETE, "BOX")


def _add_jackhammer(scene: Scene, metal: Material) -> Object:
    """A pneumatic breaker that stands on its chisel; its blows come at 30 Hz."""
    materials = (
        surface("Safety Yellow", "#f2b21b", 0.35),
        metal,
        surface("Rubber", "#1b1b1d", 0.8),
        surface("Bare Steel", "#b8bec4", 0.25, 1.0),
    )
    chisel = lathe(((0.004, 0.0), (0.022, 0.07), (0.022, 0.34)), 20).painted(3)
    retainer = lathe(((0.030, 0.30), (0.048, 0.33), (0.048, 0.40), (0.036, 0.43)), 20).painted(1)
    barrel = lathe(
        (
            (0.052, 0.42),
            (0.078, 0.48),
            (0.078, 0.80),
            (0.066, 0.83),
            (0.066, 0.89),
            (0.092, 0.93),
            (0.092, 1.03),
            (0.060, 1.08),
        )
    )
    rings = [
        cylinder(0.088, 0.022, 24, 0.005).moved(z=z).painted(1) for z in (0.54, 0.60, 0.66, 0.72)
    ]
    hose = [
        rod((0.0, 0.07, 0.98), (0.0, 0.15, 0.93), 0.020).painted(2),
        rod((0.0, 0.06, 0.98), (0.0, 0.085, 0.965), 0.030).painted(3),
    ]
    head = box((0.20, 0.13, 0.10), 0.02).moved(z=1.06).painted(1)
    bars = rod((-0.34, 0.0, 1.08), (0.34, 0.0, 1.08), 0.016).painted(3)
    grips = [
        cylinder(0.026, 0.16, 20, 0.006).turned(math.pi / 2, "Y").moved(x, 0.0, 1.08).painted(2)
        for x in (-0.28, 0.28)
    ]
    shape = joined([chisel, retainer, barrel, *rings, *hose, head, bars, *grips])
    jackhammer = place(
        scene, "Jackhammer", shape, materials, JACKHAMMER, (0.0, 0.0, math.radians(24))
    )
    make_static(scene, jackhammer, STEEL)
    return make_source(jackhammer, "PULSE", 30.0)


def _add_crates(scene: Scene) -> None:
    materials = crate_materials()
    for number, (edge, height, mass, (x, y), turn) in enumerate(CRATES, 1):
        location = (x, y, height + edge / 2)
        crate = place(
            scene,
            f"Crate {number}",
            crate_shape(edge),
            materials,
            location,
            (0.0, 0.0, math.radians(turn)),
        )
        make_dynamic(scene, crate, SOFTWOOD, mass, "BOX", restitution=0.0)


def _add_cones(scene: Scene) -> None:
    """Traffic cones: nothing haptic."""
    materials = (surface("Cone Orange", "#e8541e", 0.5), surface("Cone White", "#eeeeea", 0.4))
    cone = joined(
        (
            box((0.30, 0.30, 0.03), 0.01).moved(z=0.015),
            lathe(((0.115, 0.03), (0.085, 0.17)), 20),
            lathe(((0.086, 0.17), (0.064, 0.28)), 20).painted(1),
            lathe(((0.063, 0.28), (0.028, 0.45), (0.022, 0.46)), 20),
        )
    )
    for number, (x, y, turn) in enumerate(
        ((-2.10, -1.18, 10), (-0.98, -1.22, 40), (-2.16, 0.50, -15)), 1
    ):
        place(
            scene,
            f"Traffic Cone {number}",
            cone,
            materials,
            (x, y, 0.0),
            (0.0, 0.0, math.radians(turn)),
        )


def _add_barrier(scene: Scene) -> None:
    """A striped barrier behind the jackhammer: nothing haptic."""
    red, white, grey = 0, 1, 2
    width, height, stripes = 1.5, 0.24, 8
    slant, step = 0.12, width / 8
    planks = []
    for k in range(stripes):
        low, high = k * step - width / 2, (k + 1) * step - width / 2
        lean_low, lean_high = (0.0 if k == 0 else slant), (0.0 if k == stripes - 1 else slant)
        outline = ((low, 0.0), (high, 0.0), (high + lean_high, height), (low + lean_low, height))
        planks.append(
            prism(outline, 0.03)
            .turned(math.pi / 2, "X")
            .moved(z=0.70)
            .painted(red if k % 2 else white)
        )
    legs = [rod((x, 0.02, 0.0), (x, 0.02, 0.96), 0.022).painted(grey) for x in (-0.6, 0.6)]
    feet = [box((0.09, 0.55, 0.05), 0.012).moved(x, 0.0, 0.025).painted(grey) for x in (-0.6, 0.6)]
    materials = (
        surface("Barrier Red", "#c8281e", 0.45),
        surface("Barrier White", "#efeee9", 0.45),
        surface("Barrier Grey", "#6c7074", 0.5, 0.6),
    )
    place(
        scene,
        "Barrier",
        joined([*planks, *legs, *feet]),
        materials,
        (-1.60, 0.85, 0.0),
        (0.0, 0.0, math.radians(9)),
    )


def _add_rubble(scene: Scene) -> None:
    """What the chisel broke out of the pavers: nothing haptic."""
    draw = Random(7)
    chunks = []
    for _ in range(34):
        turn, reach, size = (
            draw.uniform(0, 2 * math.pi),
            abs(draw.gauss(0.0, 0.13)) + 0.05,
            draw.uniform(0.02, 0.065),
        )
        chunk = superellipsoid(
            (size, size * draw.uniform(0.6, 1.0), size * draw.uniform(0.4, 0.7)), 0.5, 6, 4
        )
        chunks.append(
            chunk.turned(draw.uniform(0, 6), "Z")
            .moved(reach * math.cos(turn), reach * math.sin(turn), 0.008)
            .painted(draw.randrange(2))
        )
    materials = (surface("Rubble Light", "#a19d96", 0.95), surface("Rubble Dark", "#5b5853", 0.95))
    place(scene, "Rubble", joined(chunks), materials, (JACKHAMMER[0], JACKHAMMER[1], 0.0))


def _add_surroundings(scene: Scene) -> None:
    add_backdrop(scene, surface("Backdrop", "#5f6f7d", 0.9), 40.0, -12.0, 9.0, -GROUND[2], 8.0)
    add_world(scene, "#aebccb", 0.35)
    add_three_point_light(scene, (0.0, 0.0, 0.5), 4.5)
    add_camera(scene, (-1.6, -7.0, 3.0), (0.05, 0.0, 0.45), 45.0)
