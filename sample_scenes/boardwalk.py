"""One who walks along a boardwalk and one who sits on a bench there, as imported: steps are felt in
the feet that make them, and less, through sand, on the bench."""

from __future__ import annotations

import math

from bpy.types import Object, Scene

from ..addon.authoring import body_kit
from .avatar import HANGING, seated, standing
from .gait import PREFIX, walk
from .geometry import SUNK, Geometry, box, cylinder, joined, lathe, limb, rod, superellipsoid
from .lighting import add_camera, add_sun, add_world, set_picture
from .materials import surface
from .real_content import add_character, add_instance, add_listeners, make_haptic, to_collection
from .staging import add_rigid_body_world, give_mass, place

FRAMES = 96
STRIDE_FRAMES = 26.0
START, LANE, HEADING = -1.95, -0.1, math.pi / 2
PLANK, GAP, PLANKS = (0.19, 1.5, 0.04), 0.012, 32
JOIST = (0.09, 0.12)
BEACH = SUNK - PLANK[2] - JOIST[1] + SUNK
BENCH = 0.25, 1.75, BEACH
SOLE = 0.03
MASS, LEAST_ENERGY, FULL_ENERGY = 6.0, 0.02, 0.4
"""Of a leg that comes down [kg], of steps just heard and as loud as can be [J]."""
SEAT, LEAN = 0.45, math.radians(10)


def build(scene: Scene) -> None:
    """Fill the empty ``scene``."""
    set_picture(scene, FRAMES)
    scene.haptics.minimum_energy, scene.haptics.maximum_energy = LEAST_ENERGY, FULL_ENERGY
    add_rigid_body_world(scene, FRAMES)
    fixed = [*_add_boardwalk(scene), *_add_bench(scene)]
    rig, walker = add_character(
        scene, "Walker", standing(HANGING), (START, LANE, SOLE - SUNK), heading=HEADING
    )
    boots = _add_boots(scene, rig)
    make_haptic(scene, [*fixed, *boots], {})
    people = [(rig, walker), add_character(scene, "Sitter", seated(SEAT, LEAN), BENCH)]
    for armature, body in people:
        add_listeners(scene, armature, body)
    walk(rig, range(1, FRAMES + 1), STRIDE_FRAMES, sole=SOLE - SUNK)
    _add_surroundings(scene)


def _add_boardwalk(scene: Scene) -> list[Object]:
    """Planks, one block that instances show, across two joists that lie on sand."""
    step = PLANK[0] + GAP
    length = PLANKS * step
    larch = surface("Wood_Larch", "#b08a5e", 0.75, mottle=0.35, mottle_scale=5.0)
    dark = surface("Wood_Beam", "#6d553c", 0.85)
    sand = surface("Sand_Beach", "#dcc79a", 0.95, mottle=0.2, mottle_scale=8.0)
    plank = place(scene, "Plank_A", box(PLANK, 0.006).moved(z=-PLANK[2] / 2), (larch,))
    block = to_collection("Block_Plank", [plank])
    for number in range(PLANKS):
        x = (number + 0.5) * step - length / 2
        add_instance(scene, block, f"Plank_{number + 1:02}", (x, 0.0, 0.0))
    top = SUNK - PLANK[2]
    joists = [
        place(
            scene,
            f"Joist.{number:03}",
            box((length, *JOIST)).moved(0.0, y, top - JOIST[1] / 2),
            (dark,),
        )
        for number, y in enumerate((-0.55, 0.55), 1)
    ]
    beach = box((30.0, 24.0, 0.3)).moved(0.0, 6.0, BEACH - 0.15)
    return [plank, *joists, place(scene, "Beach_low", beach, (sand,))]


def _add_bench(scene: Scene) -> list[Object]:
    """Slats to sit on and to lean on, screwed to two iron sides."""
    deep = 0.035
    seat = [
        box((1.5, 0.085, deep), 0.006).moved(0.0, 0.02 - 0.1 * k, SEAT - deep / 2) for k in range(5)
    ]
    slats = [box((1.5, 0.024, 0.1), 0.006).moved(0.0, 0.012, 0.13 + 0.13 * k) for k in range(4)]
    upright = box((0.05, 0.03, 0.72)).moved(0.0, 0.024 + 0.015 - SUNK, 0.24)
    rail = box((0.05, 0.46, 0.03)).moved(0.0, -0.18, SEAT - deep - 0.015 + SUNK)
    high = SEAT - deep + SUNK
    legs = [box((0.05, 0.05, high)).moved(0.0, y, high / 2 - SUNK) for y in (-0.36, 0.02)]
    side = joined((_leaning(upright), rail, *legs))
    teak = surface("Wood_Teak", "#9a6a3c", 0.55, mottle=0.3)
    iron = surface("Iron_Cast", "#2a2d30", 0.5, 0.6)
    shapes = {
        "Bench_Seat.001": (joined(seat), teak),
        "Bench_Back.001": (_leaning(joined(slats)), teak),
        "Bench_Sides": (joined(side.moved(x) for x in (-0.55, 0.55)), iron),
    }
    return [
        place(scene, name, shape, (material,), (0.0, *BENCH[1:]))
        for name, (shape, material) in shapes.items()
    ]


def _leaning(shape: Geometry) -> Geometry:
    """A shape above the line where back and seat meet, leaning as the back does."""
    return shape.turned(-LEAN, "X").moved(z=SEAT)


def _add_boots(scene: Scene, rig: Object) -> list[Object]:
    """Boots on the bones of the feet, each with the mass of a leg: they strike what they come down
    on."""
    leather, rubber = surface("Leather_Boot", "#5a3a24", 0.6), surface("Sole_Black", "#1b1b1d", 0.9)
    boots = []
    for side in ("Left", "Right"):
        ankle = rig.data.bones[f"{PREFIX}{side}Foot"].head_local
        upper = superellipsoid((0.108, 0.275, 0.09), 0.5).moved(0.0, -0.075, 0.04)
        shaft = cylinder(0.052, 0.09).moved(0.0, 0.0, 0.105)
        sole = box((0.098, 0.27, 0.03), 0.008).moved(0.0, -0.075, 0.015 - SOLE).painted(1)
        shape = joined((upper, shaft, sole)).moved(ankle.x, ankle.y).turned(HEADING, "Z")
        boot = place(scene, f"Boot_{side[0]}", shape, (leather, rubber))
        body_kit.attach(boot, rig, f"{PREFIX}{side}Foot", boot.location + rig.location)
        boots.append(give_mass(scene, boot, MASS))
    return boots


def _add_surroundings(scene: Scene) -> None:
    """Sea, a railing, a lamp, grass: nothing haptic."""
    sea = box((160.0, 60.0, 0.2)).moved(0.0, 38.0, BEACH + 0.02)
    place(scene, "Sea", sea, (surface("Sea", "#4f93a8", 0.15, mottle=0.3, mottle_scale=0.6),))
    sky = box((200.0, 0.2, 60.0)).moved(0.0, 68.0, 29.0)
    place(scene, "Sky", sky, (surface("Sky", "#b9dcf0", 1.0, glow=0.5),))
    white = surface("Railing_White", "#eceae4", 0.5)
    posts = [box((0.07, 0.07, 1.0), 0.01).moved(x, 2.5, 0.2) for x in (-3.2, -1.6, 0.0, 1.6, 3.2)]
    bars = [rod((-3.2, 2.5, z), (3.2, 2.5, z), 0.02) for z in (0.42, 0.74)]
    place(scene, "Railing", joined([*posts, *bars]), (white,))
    glow = surface("Lamp_Glass", "#fff3d0", 0.3, glow=1.5)
    pole = lathe(((0.07, -0.2), (0.05, 0.1), (0.03, 0.2), (0.026, 2.5), (0.06, 2.55)), 16)
    globe = superellipsoid((0.3, 0.3, 0.3), 1.0).moved(z=2.68).painted(1)
    place(
        scene,
        "Lamp_Post",
        pole + globe,
        (surface("Lamp_Iron", "#26343a", 0.5), glow),
        (-1.85, 2.65, BEACH),
    )
    blade: Geometry = limb(0.34, 0.012, 0.002)
    tuft = joined(
        blade.turned(0.25 + 0.1 * (k % 3), "X").turned(2.4 * k, "Z").moved(0.02 * (k % 4))
        for k in range(9)
    )
    green = surface("Grass_Dune", "#7d9457", 0.9)
    for number, (x, y) in enumerate(
        ((-2.6, -1.3), (-2.1, -1.45), (2.3, -1.4), (3.0, 1.5), (-3.4, 1.6), (2.4, 2.1)), 1
    ):
        place(scene, f"Grass_{number}", tuft, (green,), (x, y, BEACH), (0.0, 0.0, 1.7 * number))
    add_world(scene, "#bfe0f2", 0.75)
    add_sun(scene, "Sun", (0.5, 0.55, -0.75), 3.4, "#fff1dc")
    add_camera(scene, (-1.3, -4.9, 1.8), (0.0, 0.6, 0.5), 33.0)
