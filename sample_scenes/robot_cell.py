"""A robot that sets castings down on a table, as imported: felt by the hand that one who works
there has on it."""

from __future__ import annotations

import math
from itertools import pairwise

from bpy.types import Object, Scene
from mathutils import Vector

from .animation import animate
from .avatar import HANGING, Hand, standing
from .geometry import SUNK, box, cylinder, joined, lathe, rod, to_mesh
from .lighting import add_backdrop, add_camera, add_three_point_light, add_world, set_picture
from .materials import surface
from .real_content import add_arm, add_character, add_listeners, add_source, make_haptic
from .staging import add_rigid_body_world, give_mass, place, place_mesh

FRAMES, CYCLE = 120, 60
TABLE, HEIGHT, THICK = (2.0, 0.84), 0.88, 0.03
BASE = Vector((-0.42, 0.0, HEIGHT - SUNK))
LINKS = (0.34, 0.46, 0.42, 0.12)
"""Lengths of the column, both arms and the wrist [m]."""
FINGER, GRIP, OPEN, CLOSED = 0.12, 0.045, 0.105, 0.078
"""Length of a finger, how high it holds a casting, how far it is from the middle [m]."""
PALLET = 0.05
PICKS = tuple(Vector((-0.78, y, HEIGHT + PALLET)) for y in (-0.17, 0.15))
PLACES = (Vector((0.12, -0.16, HEIGHT)), Vector((0.17, 0.1, HEIGHT)))
LIFT = 0.18
MASS, LEAST_ENERGY, FULL_ENERGY = 8.0, 0.1, 1.2
"""Of a casting with the hand that holds it [kg], of blows just heard and as loud as can be [J];
those of the fingers that close are weaker."""
MOTOR = 0.2
"""Amplitude of the drive at full speed."""
PICK, CLOSE, LIFTED, ABOVE, SET, RELEASE, AWAY = 8, 12, 18, 32, 40, 44, 49
"""Frames of a cycle."""

TOLD = {"Robot_Orange": "aluminium", "Robot_Dark": "aluminium", "Casting_Raw": "steel"}
"""What the names of Blender materials do not tell by themselves."""

Tool = tuple[float, float, float]
"""Where the tips of the fingers are: angle about the column, distance from it, height."""


def build(scene: Scene) -> None:
    """Fill the empty ``scene``."""
    set_picture(scene, FRAMES)
    scene.haptics.minimum_energy, scene.haptics.maximum_energy = LEAST_ENERGY, FULL_ENERGY
    add_rigid_body_world(scene, FRAMES)
    cell = _add_table(scene)
    links, hubs, fingers = _add_robot(scene)
    drive = _add_drive(scene)
    castings = _add_castings(scene)
    on_table = Hand(Vector((-0.22, -0.42, HEIGHT - SUNK)), Vector((0.2, -1.0, -0.08)))
    armature, body = add_character(scene, "Operator", standing(HANGING, on_table), (0.6, 0.7, 0.0))
    make_haptic(scene, [*cell, *links, *hubs, *fingers, drive, *castings], TOLD)
    add_listeners(scene, armature, body)
    add_source(drive)
    _work(links, fingers, castings, drive)
    _add_surroundings(scene)


def _add_table(scene: Scene) -> list[Object]:
    """A steel table on a concrete floor, with a pallet on it."""
    x, y = TABLE[0] / 2 - 0.08, TABLE[1] / 2 - 0.08
    leg, block = HEIGHT - THICK + 2 * SUNK, PALLET - 0.018 + 2 * SUNK
    paint, wood = (
        surface("Steel_Frame", "#34566b", 0.5),
        surface("Wood_Pallet", "#b98d5a", 0.8, mottle=0.25),
    )
    concrete = surface("Concrete_Floor", "#8f8d88", 0.85, mottle=0.2, mottle_scale=3.0)
    rails = [box((2 * x, 0.04, 0.06)).moved(0.0, b, HEIGHT - 0.1) for b in (-y, y)]
    shapes = {
        "Table_Top": (
            box((*TABLE, THICK), 0.006).moved(z=HEIGHT - THICK / 2),
            surface("Steel_Plate", "#a4abb0", 0.4, 0.6),
        ),
        "Table_Rails": (joined(rails), paint),
        "Floor": (box((4.4, 3.4, 0.2)).moved(0.0, 0.2, -0.1), concrete),
    }
    for number, (a, b) in enumerate(((-x, -y), (-x, y), (x, -y), (x, y)), 1):
        foot = box((0.07, 0.07, leg), 0.006).moved(a, b, leg / 2 - SUNK)
        shapes[f"Table_Leg.{number:03}"] = foot, paint
    middle = PICKS[0].x
    for k in (-1, 0, 1):
        slat = box((0.1, 0.7, 0.018), 0.003)
        beam = box((0.36, 0.1, block))
        shapes[f"Pallet_Slat.{k + 2:03}"] = (
            slat.moved(middle - 0.13 * k, 0.0, HEIGHT + PALLET - 0.009),
            wood,
        )
        shapes[f"Pallet_Beam.{k + 2:03}"] = (
            beam.moved(middle, 0.28 * k, HEIGHT + block / 2 - SUNK),
            wood,
        )
    return [place(scene, name, shape, (look,)) for name, (shape, look) in shapes.items()]


def _add_robot(scene: Scene) -> tuple[list[Object], list[Object], list[Object]]:
    """Links, the hubs of their joints, and fingers."""
    orange, dark = surface("Robot_Orange", "#e8731a", 0.35), surface("Robot_Dark", "#2a2d31", 0.4)
    links = add_arm(scene, "robot", LINKS, tuple(BASE), (orange,))
    hub = cylinder(0.075, 0.19, 32, 0.006).turned(math.pi / 2, "X")
    finger = box((0.03, 0.016, FINGER + SUNK), 0.003).moved(z=LINKS[-1] + (FINGER - SUNK) / 2)
    return (
        links,
        [
            place(scene, f"robot_hub{number}", hub, (dark,), parent=link)
            for number, link in enumerate(links[1:], 1)
        ],
        [
            place_mesh(
                scene, name, to_mesh(name, finger, (dark,)), (0.0, 0.0, 0.0), parent=links[-1]
            )
            for name in ("finger_left", "finger_right")
        ],
    )


def _add_drive(scene: Scene) -> Object:
    """The motor that stands beside the column and turns it."""
    fins = [cylinder(0.068, 0.008).moved(z=0.03 * k - 0.06) for k in range(5)]
    return place(
        scene,
        "Drive_Motor",
        joined((cylinder(0.06, 0.2, 24, 0.008), *fins)),
        (surface("Motor_Steel", "#4a5157", 0.4),),
        BASE + Vector((0.0, 0.156, 0.1)),
    )


def _add_castings(scene: Scene) -> list[Object]:
    """Pots of steel, which fall as heavily as the hand that holds them."""
    pot = lathe(
        ((0.055, 0.0), (0.07, 0.012), (0.07, 0.09), (0.056, 0.09), (0.05, 0.02), (0.0, 0.02)), 32
    )
    raw = surface("Casting_Raw", "#6f6a66", 0.55, 0.6)
    return [
        give_mass(scene, place(scene, f"Casting.{number:03}", pot, (raw,), spot), MASS)
        for number, spot in enumerate(PICKS, 1)
    ]


def _tool(spot: Vector, lift: float = 0.0) -> Tool:
    """The tool that holds a casting which stands at a place, or that far above it."""
    way = spot - BASE
    return math.atan2(way.y, way.x) % (2 * math.pi), way.to_2d().length, spot.z + GRIP + lift


def _way() -> tuple[dict[int, Tool], list[dict[int, Tool]]]:
    """The tool in each frame, and in those of its cycle in which it holds a casting."""
    stops: dict[int, Tool] = {}
    for cycle, (pick, spot) in enumerate(zip(PICKS, PLACES, strict=True)):
        at = 1 + CYCLE * cycle
        stops |= {at: _tool(pick, LIFT), at + PICK: _tool(pick), at + CLOSE: _tool(pick)}
        stops |= {at + LIFTED: _tool(pick, LIFT), at + ABOVE: _tool(spot, LIFT)}
        stops |= {at + SET: _tool(spot), at + RELEASE: _tool(spot), at + AWAY: _tool(spot, LIFT)}
    stops[FRAMES + 1] = _tool(PICKS[0], LIFT)
    ways: dict[int, Tool] = {}
    for (first, begin), (last, end) in pairwise(stops.items()):
        for frame in range(first, last):
            part = (frame - first) / (last - first)
            # Castings come down at an even speed; everything else begins and ends at rest.
            even = part if (first - 1) % CYCLE == ABOVE else part * part * (3 - 2 * part)
            turn, reach, height = (a + (b - a) * even for a, b in zip(begin, end, strict=True))
            ways[frame] = turn, reach, height
    held = [
        {frame: ways[frame] for frame in range(at + CLOSE, at + SET + 1)} for at in (1, 1 + CYCLE)
    ]
    return ways, held


def _work(
    links: list[Object], fingers: list[Object], castings: list[Object], drive: Object
) -> None:
    """Animate all of them."""
    ways, held = _way()
    turns = {frame: _joints(tool) for frame, tool in ways.items()}
    for number, link in enumerate(links):
        axis = 1 if number else 2
        animate(
            link,
            "rotation_euler",
            {
                frame: tuple(turn[number] if k == axis else 0.0 for k in range(3))
                for frame, turn in turns.items()
            },
        )
    for side, finger in zip((1.0, -1.0), fingers, strict=True):
        stages = ((0, OPEN), (PICK, OPEN), (CLOSE, CLOSED), (SET, CLOSED), (RELEASE, OPEN))
        keys = {1 + at + CYCLE * k: (0.0, side * wide, 0.0) for k in (0, 1) for at, wide in stages}
        animate(finger, "location", keys)
    for casting, pick, own in zip(castings, PICKS, held, strict=True):
        rise = casting.location - pick
        keys = {
            frame: BASE.to_2d().to_3d()
            + Vector((reach * math.cos(turn), reach * math.sin(turn), height - GRIP))
            + rise
            for frame, (turn, reach, height) in own.items()
        }
        animate(casting, "location", keys)
    speeds = {frame: abs(ways[min(frame + 1, FRAMES)][0] - tool[0]) for frame, tool in ways.items()}
    fastest = max(speeds.values())
    animate(
        drive,
        "haptics.source.amplitude",
        {frame: MOTOR * speed / fastest for frame, speed in speeds.items()},
    )


def _joints(tool: Tool) -> tuple[float, float, float, float]:
    """The turns of the column about its axis, and of arms and wrist from what carries them; the
    fingers point down."""
    turn, reach, height = tool
    rise = height + FINGER + LINKS[3] - BASE.z - LINKS[0]
    upper, lower, way = LINKS[1], LINKS[2], math.hypot(reach, rise)
    inner = math.acos((upper**2 + way**2 - lower**2) / (2 * upper * way))
    outer = math.acos((upper**2 + lower**2 - way**2) / (2 * upper * lower))
    shoulder, elbow = math.atan2(reach, rise) - inner, math.pi - outer
    return turn, shoulder, elbow, math.pi - shoulder - elbow


def _add_surroundings(scene: Scene) -> None:
    """A hall with a fence, a stripe on its floor and a lamp: nothing haptic."""
    yellow = surface("Stripe_Yellow", "#e2b51f", 0.7)
    place(scene, "Stripe", box((3.6, 0.06, 0.004)).moved(0.0, -0.85, 0.002), (yellow,))
    wire = surface("Fence_Wire", "#30363b", 0.5)
    wide, rise = 0.62, 1.3
    post = box((0.05, 0.05, rise), 0.006).moved(z=rise / 2)
    wires = [rod((0.0, 0.0, z), (wide, 0.0, z), 0.005, 6) for z in (0.15, 0.45, 0.75, 1.05, 1.25)]
    wires += [rod((wide * k / 6, 0.0, 0.15), (wide * k / 6, 0.0, 1.25), 0.004, 6) for k in range(6)]
    for number in range(8):
        at = (wide * (number - 3.5), 1.5, 0.0)
        place(scene, f"Fence_Post_{number + 1}", post, (yellow,), at)
        if number < 7:
            place(scene, f"Fence_{number + 1}", joined(wires), (wire,), at)
    lamp = joined((cylinder(0.02, 1.2).moved(z=0.6), cylinder(0.03, 0.16).moved(z=1.28).painted(1)))
    place(
        scene,
        "Signal_Lamp",
        lamp,
        (surface("Lamp_Pole", "#5d6469", 0.5), surface("Lamp_Green", "#3fd07a", 0.3, glow=2.0)),
        (-1.25, 0.9, 0.0),
    )
    add_backdrop(scene, surface("Backdrop", "#5c6b76", 0.95), 30.0, -9.0, 6.0, -0.2, 7.0)
    add_world(scene, "#c3ccd6", 0.35)
    add_three_point_light(scene, (0.0, 0.1, 0.9), 3.6)
    add_camera(scene, (-1.0, -4.2, 2.2), (0.02, 0.1, 0.9), 40.0)
