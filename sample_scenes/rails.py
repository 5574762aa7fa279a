"""A far train felt through rails rather than soil.

The track is broken before the locomotive: its rumble crosses the gap through the ground, runs along
the rails and comes back to the ground beside the bench. Waves spread over the soil, and run along
the rails.
"""

from __future__ import annotations

import math
from random import Random

from bpy.types import Material, Object, Scene

from .animation import animate
from .avatar import TURNED_UP, build_avatar, seated
from .furniture import add_bench
from .geometry import SUNK, box, cylinder, joined, lathe, rod, superellipsoid
from .lighting import add_area_light, add_camera, add_sun, add_world, set_picture
from .materials import SOIL, STEEL, bind, surface
from .railway import add_rails, add_sleepers, on_rails, wheelset
from .staging import add_rigid_body_world, make_source, make_static, place

FRAMES = 120
GROUND = (52.0, 16.0, 0.5)
FAR_TRACK, NEAR_TRACK = (-22.0, -11.0), (-10.0, 18.0)
SLEEPER_SPACING = 1.0
BENCH = (11.5, -1.95, 0.0)
SEAT_HEIGHT, LEAN = 0.45, math.radians(10)
WHEEL = 0.42
LOCOMOTIVE_X = -16.5
SPEED_IN_STEEL, SPEED_IN_SOIL = 5000.0, 200.0  # metres per second


def build(scene: Scene) -> None:
    """Fill the empty ``scene``."""
    set_picture(scene, FRAMES)
    add_rigid_body_world(scene, FRAMES)
    _add_ground(scene)
    wood, steel = (
        surface("Sleeper", "#54402f", 0.85, mottle=0.35),
        surface("Rail Steel", "#7d746c", 0.35, 0.9),
    )
    for name, (low, high) in (("Far", FAR_TRACK), ("Near", NEAR_TRACK)):
        count = round((high - low) / SLEEPER_SPACING)
        add_sleepers(
            scene,
            f"{name} Sleeper",
            wood,
            [low + (k + 0.5) * SLEEPER_SPACING for k in range(count)],
        )
        for rail in add_rails(scene, f"{name} Rail", steel, low, high):
            rail.haptics.wave_speed = SPEED_IN_STEEL
    _add_locomotive(scene)
    bench_wood, metal = (
        surface("Bench Wood", "#b9804a", 0.55, mottle=0.35, mottle_scale=9.0),
        surface("Dark Metal", "#33383d", 0.4, 0.8),
    )
    add_bench(scene, BENCH, bench_wood, metal, height=SEAT_HEIGHT, lean=LEAN)
    build_avatar(scene, seated(SEAT_HEIGHT, LEAN), BENCH, gain=TURNED_UP)
    _add_gap(scene)
    _add_trees(scene)
    _add_surroundings(scene)


def _add_ground(scene: Scene) -> Object:
    """Grass with a bed of gravel along the track, flush with it; one haptic object."""
    length, width, height = GROUND
    slab = box((length, width, height), 0.04).moved(z=-height / 2)
    gravel = box((length, 3.4, 0.02)).moved(z=-0.006).painted(1)
    grass = surface("Grass", "#6b8a4a", 0.95, mottle=0.3, mottle_scale=1.5)
    materials = (grass, surface("Gravel", "#8d877d", 0.95, mottle=0.45, mottle_scale=14.0))
    ground = place(scene, "Ground", joined([slab, gravel]), materials)
    make_static(scene, ground, SOIL, "BOX")
    ground.haptics.wave_speed = SPEED_IN_SOIL
    for substance in (SOIL, STEEL):  # the track's bed holds the sleepers, and these the rails
        bind(scene, substance)
    return ground


def _add_locomotive(scene: Scene) -> Object:
    """A shunter on two wheelsets, which idles and revs up."""
    red, dark = surface("Locomotive Red", "#b5322a", 0.35), surface("Undercarriage", "#2b2d30", 0.6)
    yellow, glass = surface("Warning Yellow", "#e8b21f", 0.4), surface("Window", "#27343c", 0.15)
    lamp, iron = (
        surface("Headlight", "#fff1c9", 0.3, glow=12.0),
        surface("Wheel Iron", "#4a4c50", 0.4, 0.9),
    )
    chassis = 2 * WHEEL + on_rails(WHEEL)[2] - WHEEL - SUNK  # underside
    frame = box((6.6, 2.5, 0.34), 0.03).moved(z=0.17).painted(1)
    hood = box((4.1, 1.5, 1.25), 0.10).moved(0.95, 0.0, 0.34 + 0.625)
    cab = box((1.9, 2.4, 2.05), 0.06).moved(-2.05, 0.0, 0.34 + 1.025)
    roof = box((2.15, 2.6, 0.12), 0.05).moved(-2.05, 0.0, 2.43).painted(1)
    panes = [box((0.02, 0.75, 0.62), 0.02).moved(-1.09, y, 1.80).painted(3) for y in (-0.75, 0.75)]
    panes += [
        box((1.1, 0.02, 0.62), 0.02).moved(-2.05, y, 1.80).painted(3) for y in (-1.205, 1.205)
    ]
    grille = [
        box((0.02, 1.1, 0.045)).moved(3.01, 0.0, 0.65 + 0.09 * k).painted(1) for k in range(9)
    ]
    lamps = [
        cylinder(0.11, 0.05, 20, 0.01).turned(math.pi / 2, "Y").moved(3.02, y, 1.50).painted(4)
        for y in (-0.5, 0.5)
    ]
    stripes = [
        box((0.02, 0.28, 0.30)).moved(3.305, -1.05 + 0.42 * k, 0.17).painted(2) for k in range(6)
    ]
    buffers = [
        cylinder(0.165, 0.08, 20, 0.02).turned(math.pi / 2, "Y").moved(3.62, y, 0.17).painted(1)
        for y in (-0.87, 0.87)
    ]
    buffers += [rod((3.3, y, 0.17), (3.6, y, 0.17), 0.08).painted(1) for y in (-0.87, 0.87)]
    chimney = lathe(((0.13, 0.0), (0.13, 0.35), (0.17, 0.40))).moved(1.7, 0.3, 1.58).painted(1)
    rail = [rod((-0.9, y, 1.05), (3.0, y, 1.05), 0.022).painted(2) for y in (-1.15, 1.15)]
    posts = [
        rod((x, y, 0.3), (x, y, 1.06), 0.022).painted(2)
        for y in (-1.15, 1.15)
        for x in (-0.85, 1.05, 2.95)
    ]
    shape = joined(
        [
            frame,
            hood,
            cab,
            roof,
            *panes,
            *grille,
            *lamps,
            *stripes,
            *buffers,
            chimney,
            *rail,
            *posts,
        ]
    )
    locomotive = place(
        scene,
        "Locomotive",
        shape,
        (red, dark, yellow, glass, lamp, iron),
        (LOCOMOTIVE_X, 0.0, chassis),
    )
    make_static(scene, locomotive, STEEL)
    for number, x in enumerate((-1.75, 1.75), 1):
        _, _, z = on_rails(WHEEL)
        wheels = place(
            scene, f"Wheelset {number}", wheelset(WHEEL), (iron, dark), (LOCOMOTIVE_X + x, 0.0, z)
        )
        make_static(scene, wheels, STEEL)
    _add_axle_boxes(scene, dark, chassis)
    make_source(locomotive, "NOISE")
    animate(
        locomotive,
        "haptics.source.amplitude",
        {1.0: 0.4, 40.0: 0.4, 70.0: 1.0, 100.0: 1.0, float(FRAMES): 0.4},
    )
    return locomotive


def _add_axle_boxes(scene: Scene, dark: Material, chassis: float) -> None:
    """What hides the wheels' ends: nothing haptic."""
    plates = [
        box((1.1, 0.06, 0.36), 0.03).moved(x, y, -0.16)
        for x in (-1.75, 1.75)
        for y in (-0.98, 0.98)
    ]
    place(scene, "Axle Boxes", joined(plates), (dark,), (LOCOMOTIVE_X, 0.0, chassis))


def _add_gap(scene: Scene) -> None:
    """A stop board in the gap of the track: nothing haptic."""
    board = joined(
        (
            cylinder(0.30, 0.03, 32, 0.005).turned(math.pi / 2, "Y").moved(z=1.35),
            cylinder(0.24, 0.034, 32).turned(math.pi / 2, "Y").moved(z=1.35).painted(1),
            rod((0.0, 0.0, 0.0), (0.0, 0.0, 1.2), 0.03).painted(2),
        )
    )
    red, grey = (
        surface("Signal Red", "#c8281e", 0.4, glow=0.3),
        surface("Post Grey", "#6c7074", 0.5, 0.6),
    )
    materials = (surface("Signal White", "#eeeeea", 0.4), red, grey)
    place(scene, "Stop Board", board, materials, ((FAR_TRACK[1] + NEAR_TRACK[0]) / 2, 0.0, 0.0))


def _add_trees(scene: Scene) -> None:
    """Trees and bushes along the line: nothing haptic."""
    draw = Random(11)
    leaf, bark = surface("Leaf", "#4c7a3d", 0.9, mottle=0.3), surface("Trunk", "#5b4230", 0.9)
    dark_leaf = surface("Fir", "#35593a", 0.9, mottle=0.3)
    for number in range(1, 19):
        x, y = draw.uniform(-23.0, 9.0), draw.uniform(3.6, 7.4)
        size = draw.uniform(0.8, 1.25)
        trunk = lathe(((0.12, 0.0), (0.09, 1.1 * size))).painted(1)
        if number % 3 == 0:
            crowns = [
                superellipsoid((1.7 * size, 1.7 * size, 1.8 * size), 0.9, 14, 9).moved(z=1.7 * size)
            ]
        else:
            tiers = ((0.95, 0.70), (0.74, 1.45), (0.52, 2.20))
            crowns = [
                lathe(((reach * size, 0.0), (0.0, 1.3 * size)), 14).moved(z=z * size)
                for reach, z in tiers
            ]
        materials = (leaf if number % 3 == 0 else dark_leaf, bark)
        place(
            scene,
            f"Tree {number}",
            joined([trunk, *crowns]),
            materials,
            (x, y, -0.02),
            (0.0, 0.0, draw.uniform(0.0, 6.0)),
        )


def _add_surroundings(scene: Scene) -> Object:
    meadow = box((260.0, 260.0, 0.1)).moved(z=-GROUND[2])
    place(
        scene,
        "Meadow",
        meadow,
        (surface("Meadow", "#7c9457", 0.95, mottle=0.2, mottle_scale=0.15),),
    )
    add_world(scene, "#a9cdf0", 0.9)
    add_sun(scene, "Sun", (-0.45, 0.75, -0.75), 3.0, "#fff0d8")
    add_area_light(
        scene, "Bench Light", (14.5, -5.0, 3.2), (11.5, -2.2, 0.7), 120.0, 2.0, "#fff3e0"
    )
    return add_camera(scene, (16.4, -5.3, 1.95), (6.2, -1.25, 0.72), 34.0)
