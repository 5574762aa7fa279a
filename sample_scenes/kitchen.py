"""A cook at a kitchen island, as imported: the hand on the worktop feels the mixer, and through
floor and cupboards the fridge."""

from __future__ import annotations

import math

from bpy.types import Object, Scene
from mathutils import Vector

from .animation import CONSTANT, animate
from .avatar import Hand, standing
from .geometry import SUNK, Geometry, box, cylinder, joined, lathe, rod, superellipsoid, torus
from .lighting import (
    add_area_light,
    add_backdrop,
    add_camera,
    add_three_point_light,
    add_world,
    set_picture,
)
from .materials import surface
from .real_content import (
    BOWL,
    BOWL_STEP,
    add_character,
    add_instance,
    add_listeners,
    add_source,
    make_haptic,
    to_collection,
)
from .staging import add_rigid_body_world, place

FRAMES = 120
START, STOP = 37, 97
"""Frames in which the mixer runs."""
MIXER, COMPRESSOR = 0.3, 0.5
"""Amplitudes."""
TURNS, HUM = 120.0, 100.0
"""The mixer's revolutions per second; how often the mains pull the compressor's armature [Hz]."""
ISLAND, HEIGHT, THICK = -0.38, 0.9, 0.04
"""Where the middle of the island is, how high its top is and how thick [m]."""
CUPBOARD, BOARD = (0.6, 0.6), 0.018
"""Width and depth of a cupboard, thickness of its boards [m]."""
COOK = Vector((0.12, 0.36, 0.0))
STAND = Vector((0.62, ISLAND, HEIGHT - SUNK))
FRIDGE, FRIDGE_SIZE = Vector((-0.98, 1.1, 0.0)), (0.62, 0.58, 1.7)
FLOOR = (4.2, 3.2, 0.15)

TOLD = {
    "Lacquer_Sage": "hardwood",
    "Fridge_White": "steel",
    "Fridge_Black": "steel",
    "Mixer_Red": "aluminium",
    "Tiles_Floor": "concrete",
}
"""What the names of Blender materials do not tell by themselves."""


def build(scene: Scene) -> None:
    """Fill the empty ``scene``."""
    set_picture(scene, FRAMES)
    add_rigid_body_world(scene, FRAMES)
    parts = [*_add_room(scene), *_add_cupboards(scene), *_add_bowls(scene), *_add_board(scene)]
    fridge, compressor = _add_fridge(scene)
    mixer, motor = _add_mixer(scene)
    resting = Hand(Vector((0.2, -0.42, HEIGHT - SUNK)), Vector((-0.25, -1.0, -0.06)))
    stirring = Hand(Vector((-0.2, -0.4, HEIGHT + 0.24)), Vector((0.35, -1.0, -0.3)))
    armature, body = add_character(scene, "Cook", standing(resting, stirring), tuple(COOK))
    make_haptic(scene, [*parts, *fridge, compressor, *mixer, motor], TOLD)
    add_listeners(scene, armature, body)
    hum, mixing = (add_source(obj).haptics.source for obj in (compressor, motor))
    hum.amplitude, hum.frequency, mixing.frequency = COMPRESSOR, HUM, TURNS
    animate(
        motor,
        "haptics.source.amplitude",
        {1: 0.0, START: MIXER, STOP: 0.0},
        CONSTANT,
    )
    _add_surroundings(scene)


def _add_room(scene: Scene) -> list[Object]:
    """A tiled floor and a brick wall on it, with a shelf."""
    columns, rows = 14, 11
    x, y = FLOOR[0] / columns, FLOOR[1] / rows
    tiles = [
        box((x - 0.008, y - 0.008, 0.02), 0.002)
        .moved((i + 0.5) * x - FLOOR[0] / 2, (j + 0.5) * y - FLOOR[1] / 2, -0.01)
        .painted((i + j) % 2)
        for i in range(columns)
        for j in range(rows)
    ]
    slab = box((*FLOOR[:2], FLOOR[2] - 0.005)).moved(z=-(FLOOR[2] + 0.005) / 2)
    colours = (surface("Tiles_Floor", "#c9c3b5", 0.35), surface("Tiles_Dark", "#8b9391", 0.35))
    wall = box((FLOOR[0], 0.1, 2.3)).moved(0.0, FLOOR[1] / 2 - 0.05, 1.15 - SUNK)
    brick = surface("Brick_Painted", "#d9cfbf", 0.9, mottle=0.12, mottle_scale=30.0)
    shelf = box((1.5, 0.26, 0.03), 0.004).moved(0.55, FLOOR[1] / 2 - 0.1 - 0.13 + SUNK, 1.45)
    return [
        place(scene, "Floor", joined([*tiles, slab]), colours),
        place(scene, "Wall", wall, (brick,)),
        place(scene, "Wall_Shelf", shelf, (surface("Wood_Oak", "#a9763f", 0.55, mottle=0.25),)),
    ]


def _add_cupboards(scene: Scene) -> list[Object]:
    """Open cupboards, one block that instances show, and the worktop that lies on them."""
    width, depth = CUPBOARD
    height = HEIGHT - THICK + SUNK
    side = box((BOARD, depth, height)).moved(z=height / 2 - SUNK)
    inner = width - 2 * BOARD + 2 * SUNK
    level = box((inner, depth - BOARD, BOARD)).moved(0.0, -BOARD / 2)
    back = box((inner, BOARD, height)).moved(0.0, (depth - BOARD) / 2, height / 2 - SUNK)
    carcass = joined(
        (
            *(side.moved(x) for x in ((BOARD - width) / 2, (width - BOARD) / 2)),
            *(level.moved(z=z - BOARD / 2) for z in _levels()),
            back,
        )
    )
    sage = surface("Lacquer_Sage", "#7f9a86", 0.45)
    cupboard = place(scene, "Cupboard_Open", carcass, (sage,))
    block = to_collection("Block_Cupboard", [cupboard])
    for number, x in enumerate((-width, 0.0, width), 1):
        add_instance(scene, block, f"Cupboard_{number:02}", (x, ISLAND, 0.0))
    top = box((3 * width + 0.08, depth + 0.1, THICK), 0.006).moved(0.0, ISLAND, HEIGHT - THICK / 2)
    oak = surface("Wood_Worktop", "#b98a55", 0.5, mottle=0.3, mottle_scale=7.0)
    return [cupboard, place(scene, "Worktop.001", top, (oak,))]


def _levels() -> tuple[float, float]:
    """The upper sides of a cupboard's boards."""
    return 0.1, 0.46


def _add_bowls(scene: Scene) -> list[Object]:
    """Bowls that stand in each other, on the boards and the shelf."""
    bowls, blocks = [], []
    for name, colour in (("White", "#ece8df"), ("Blue", "#44657f"), ("Ochre", "#c68a3a")):
        glaze = surface(f"Ceramic_{name}", colour, 0.25)
        bowls.append(place(scene, f"Bowl_{name}", lathe(BOWL), (glaze,)))
        blocks.append(to_collection(f"Block_Bowl_{name}", [bowls[-1]]))
    spots = [
        (x + shift, ISLAND - 0.08, level)
        for level in _levels()
        for x in (-CUPBOARD[0], 0.0, CUPBOARD[0])
        for shift in (-0.13, 0.13)
    ]
    spots += [(x, FLOOR[1] / 2 - 0.23, 1.465) for x in (0.0, 0.3, 0.6, 0.9, 1.15)]
    number = 0
    for stack, (x, y, z) in enumerate(spots):
        for layer in range(2 + stack % 3):
            number += 1
            at = (x, y, z - SUNK + layer * BOWL_STEP)
            add_instance(scene, blocks[stack % 3], f"Bowl.{number:03}", at)
    return bowls


def _add_board(scene: Scene) -> list[Object]:
    """A chopping board, on it the bowl that is stirred, the spoon in the cook's hand."""
    beech = surface("Wood_Beech", "#d2a56d", 0.5)
    board = box((0.42, 0.28, 0.02), 0.005).moved(-0.12, ISLAND - 0.02, HEIGHT + 0.01 - SUNK)
    copper = surface("Brass_Pan", "#b5713c", 0.25, 1.0)
    pan = lathe(((0.09, 0.0), (0.13, 0.1), (0.127, 0.1), (0.086, 0.006)), 32)
    at = (-0.1, ISLAND + 0.02, HEIGHT + 0.02 - 2 * SUNK)
    spoon = rod((-0.08, -0.03, HEIGHT + 0.28), (-0.13, ISLAND + 0.05, HEIGHT + 0.06), 0.009)
    place(scene, "Spoon", spoon, (beech,))
    return [place(scene, "Board", board, (beech,)), place(scene, "Pan", pan, (copper,), at)]


def _add_fridge(scene: Scene) -> tuple[list[Object], Object]:
    """A fridge with its doors, and the compressor below it."""
    width, depth, height = FRIDGE_SIZE
    white, black = surface("Fridge_White", "#dfe3e2", 0.25), surface("Fridge_Black", "#25282b", 0.4)
    low, gap = 0.16, 0.006
    walls = [box((width, depth, 0.03)).moved(z=z + 0.015) for z in (low, low + 0.55, height - 0.03)]
    walls += [
        box((0.03, depth, height - low)).moved(x, 0.0, (height + low) / 2)
        for x in ((0.03 - width) / 2, (width - 0.03) / 2)
    ]
    walls.append(
        box((width, 0.03, height - low)).moved(0.0, (depth - 0.03) / 2, (height + low) / 2)
    )
    feet = [
        box((0.05, 0.05, low + 2 * SUNK)).moved(x, y, low / 2).painted(1)
        for x in (-0.25, 0.25)
        for y in (-0.22, 0.22)
    ]
    doors: list[Geometry] = []
    for bottom, top in ((low, low + 0.55 - gap), (low + 0.55 + gap, height)):
        door = box((width, 0.05, top - bottom), 0.012)
        handle = rod((0.24, -0.07, -0.16), (0.24, -0.07, 0.16), 0.011).painted(1)
        posts = [rod((0.24, -0.07, z), (0.24, -0.02, z), 0.008).painted(1) for z in (-0.14, 0.14)]
        middle = (0.0, -(depth + 0.05) / 2 + SUNK, (bottom + top) / 2)
        doors.append(joined((door, handle, *posts)).moved(*middle))
    tank = superellipsoid((0.26, 0.2, low - 0.01), 0.7).moved(0.0, -0.12, low / 2 + SUNK)
    compressor = place(scene, "Compressor", tank, (black,), FRIDGE)
    names = ("Fridge_Body", "Fridge_Door.001", "Fridge_Door.002")
    shapes = (joined((*walls, *feet)), *doors)
    return [
        place(scene, name, shape, (white, black), FRIDGE)
        for name, shape in zip(names, shapes, strict=True)
    ], compressor


def _add_mixer(scene: Scene) -> tuple[list[Object], Object]:
    """A mixer: stand, bowl with a whisk in it, and the head with its motor."""
    red, steel = surface("Mixer_Red", "#b3261d", 0.25), surface("Steel_Bowl", "#c3c7ca", 0.25, 0.9)
    stand = joined(
        (
            box((0.22, 0.36, 0.035), 0.012).moved(0.0, -0.03, 0.0175),
            superellipsoid((0.13, 0.11, 0.3), 0.4).moved(0.0, 0.1, 0.16),
        )
    )
    head = superellipsoid((0.15, 0.36, 0.14), 0.6).moved(0.0, -0.02, 0.345)
    knob = cylinder(0.03, 0.02, 20, 0.004).turned(math.pi / 2, "Y").moved(0.078, -0.02, 0.345)
    bowl = lathe(
        ((0.06, 0.0), (0.09, 0.03), (0.115, 0.15), (0.112, 0.15), (0.085, 0.03), (0.0, 0.01)), 32
    )
    whisk = [
        torus(0.05, 0.0025, 20, 6)
        .turned(math.pi / 2, "X")
        .turned(k * math.pi / 4, "Z")
        .moved(z=0.16)
        for k in range(4)
    ]
    shaft = rod((0.0, 0.0, 0.2), (0.0, 0.0, 0.29), 0.012)
    beater = place(
        scene, "Mixer_Whisk", joined((*whisk, shaft)), (steel,), STAND + Vector((0.0, -0.08, 0.0))
    )
    turns = {START: (0.0, 0.0, 0.0), STOP: (0.0, 0.0, 2 * math.pi * (STOP - START) / 8)}
    animate(beater, "rotation_euler", turns)
    return [
        place(scene, "Mixer_Stand", stand, (red,), STAND),
        place(scene, "Mixer_Bowl.001", bowl, (steel,), STAND + Vector((0.0, -0.08, 0.035 - SUNK))),
        beater,
    ], place(scene, "Mixer_Motor", head + knob.painted(1), (red, steel), STAND)


def _add_surroundings(scene: Scene) -> None:
    """A lamp above the island, a plant: nothing haptic."""
    shade = lathe(((0.03, 0.12), (0.16, 0.0), (0.155, 0.0), (0.025, 0.11)), 32)
    cord = rod((0.0, 0.0, 0.12), (0.0, 0.0, 0.9), 0.004)
    enamel = surface("Lamp_Enamel", "#2f4a3c", 0.35)
    for number, x in enumerate((-0.62, 0.62), 1):
        place(scene, f"Lamp_{number}", joined((shade, cord)), (enamel,), (x, ISLAND, 1.78))
        add_area_light(
            scene, f"Lamp_Light_{number}", (x, ISLAND, 1.76), (x, ISLAND, 0.0), 18.0, 0.3, "#ffe2b8"
        )
    add_backdrop(scene, surface("Backdrop", "#7d776d", 0.95), 30.0, -9.0, 6.0, -FLOOR[2], 7.0)
    add_world(scene, "#d8d6d0", 0.3)
    add_three_point_light(scene, (0.0, 0.0, 0.9), 3.6)
    add_camera(scene, (1.15, -4.1, 2.05), (-0.06, 0.1, 0.84), 38.0)
