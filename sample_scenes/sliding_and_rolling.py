"""Five objects that slide or roll in turn: a file, a ball, a shoe, a crate and a wheelset, each
felt nearby."""

from __future__ import annotations

import math
from random import Random

from bpy.types import Material, Object, Scene
from mathutils import Matrix, Vector

from ..core.scene.materials import MATERIALS
from .animation import animate
from .avatar import Avatar, Hand, build_avatar, standing
from .crates import crate_materials, crate_shape
from .furniture import add_table
from .geometry import SUNK, box, cylinder, joined, lathe, prism, rod, sphere, superellipsoid
from .lighting import add_backdrop, add_camera, add_three_point_light, add_world, set_picture
from .materials import CONCRETE, HARDWOOD, SOFTWOOD, STEEL, surface
from .railway import RAIL_HEIGHT, add_rails, wheelset
from .staging import add_rigid_body_world, add_texture, make_moving, make_static, place, place_empty

SECTIONS = {
    "File": (4, 56),
    "Ball": (64, 112),
    "Shoe": (120, 168),
    "Crate": (176, 240),
    "Wheel": (248, 296),
}
"""First and last frame in which each thing moves; at rest they are silent."""
FRAMES = 304

YARD = (5.6, 5.0, 0.16)
YARD_Y = 0.75
BED, BED_X = (0.66, 0.84, 0.05), 0.33
BED_TOP = 2 * SUNK
TABLE_HEIGHT = 0.92
BENCH_Y = -0.70
BAR = Vector((-0.30, -0.62, TABLE_HEIGHT + 0.16))  # middle of its upper side
GRIP = BAR + Vector((0.0, 0.225, 0.026))  # middle of the file's handle, at its upper side
STROKE = math.radians(9)
BALL, BALL_Y, BALL_X = 0.045, -0.60, (0.08, 0.62)
STEP = math.radians(6)
CRATE, CRATE_X, CRATE_Y = 0.5, -1.45, (0.35, -0.75)
CRATE_MASS = 60.0
WHEEL, TRACK_Y, TRACK_X = 0.3, 1.40, (-2.2, 2.2)


def build(scene: Scene) -> None:
    """Fill the empty ``scene``."""
    set_picture(scene, FRAMES)
    add_rigid_body_world(scene, FRAMES)
    for name, (first, _) in SECTIONS.items():
        scene.timeline_markers.new(name, frame=first)
    steel = surface("Bare Steel", "#aeb4ba", 0.28, 1.0)
    _add_ground(scene)
    wood, legs = (
        surface("Bench Wood", "#b98a52", 0.5, mottle=0.3, mottle_scale=7.0),
        surface("Bench Legs", "#6d4a2a", 0.6),
    )
    add_table(
        scene, "Bench", (0.10, BENCH_Y, 0.0), wood, legs, size=(1.4, 0.60), height=TABLE_HEIGHT
    )
    avatar = _add_worker(scene)
    _add_file(scene, avatar, steel)
    _add_ball(scene)
    _add_step(scene, avatar)
    _add_crate(scene)
    _add_wheels(scene, steel)
    _add_textures(scene)
    _add_surroundings(scene)


def _waves(first: int, last: int, count: int) -> dict[float, float]:
    """By frame, a sine of ``count`` periods between two frames, which begins and ends at rest."""
    parts = {frame: (frame - first) / (last - first) for frame in range(first, last + 1)}
    return {
        float(frame): math.sin(2 * math.pi * count * part) * math.sin(math.pi * part)
        for frame, part in parts.items()
    }


def _there(first: int, last: int) -> dict[float, float]:
    """By frame, 0 up to the first and 1 from the last on, with a smooth start and end of a tenth of
    the time."""
    ease, result = 0.1, {}
    for frame in range(first, last + 1):
        part = (frame - first) / (last - first)
        low, high = min(part, ease), max(part - (1 - ease), 0.0)
        result[float(frame)] = (
            low * low / (2 * ease)
            + max(min(part, 1 - ease) - ease, 0.0)
            + high
            - high * high / (2 * ease)
        ) / (1 - ease)
    return result


def _add_ground(scene: Scene) -> None:
    """A concrete yard with a bed of gravel in it, whose pebbles are mere looks."""
    yard = place(
        scene,
        "Yard",
        box(YARD, 0.02).moved(0.0, YARD_Y, -YARD[2] / 2),
        (surface("Concrete", "#8d8a85", 0.9, mottle=0.25),),
    )
    make_static(scene, yard, CONCRETE, "BOX")
    draw = Random(5)
    grey, brown = (
        surface("Gravel", "#8d877d", 0.95, mottle=0.4, mottle_scale=30.0),
        surface("Pebble", "#a39a8c", 0.85, mottle=0.3),
    )
    bed = place(scene, "Gravel Bed", box(BED, 0.02), (grey,), (BED_X, 0.0, BED_TOP - BED[2] / 2))
    make_static(scene, bed, MATERIALS["gravel"], "BOX")
    pebbles = []
    for _ in range(200):
        size = draw.uniform(0.014, 0.034)
        x, y = (draw.uniform(0.01 - side / 2, side / 2 - 0.01) for side in BED[:2])
        pebbles.append(
            superellipsoid((size, size * draw.uniform(0.7, 1.0), size * 0.6), 0.8, 8, 5)
            .turned(draw.uniform(0, 3), "Z")
            .moved(x, y)
        )
    place(scene, "Pebbles", joined(pebbles), (brown,), (BED_X, 0.0, BED_TOP - SUNK))


def _add_worker(scene: Scene) -> Avatar:
    """The avatar, its left foot on the gravel, the right hand on the file's handle, the left one on
    the bench."""
    up = Vector((0.0, 0.0, BED_TOP - SUNK))
    left = Hand(
        Vector((0.36, BENCH_Y + 0.20, TABLE_HEIGHT - 2 * SUNK)) - up, Vector((-0.25, -1.0, -0.08))
    )
    right = Hand(GRIP - up, Vector((0.12, -1.0, -0.12)))
    return build_avatar(scene, standing(left, right), tuple(up), moving=True)


def _add_file(scene: Scene, avatar: Avatar, steel: Material) -> None:
    """A rough file that goes to and fro over a bar in a vice, with the right arm, whose hand stays
    at the height of the handle."""
    bar = place(
        scene, "Bar", box((0.06, 0.024, 0.16), 0.002), (steel,), BAR - Vector((0.0, 0.0, 0.08))
    )
    make_static(scene, bar, STEEL, "BOX")
    iron = surface("Vice", "#2f5468", 0.45, 0.7)
    jaws = [box((0.15, 0.035, 0.09), 0.006).moved(0.0, y, 0.075) for y in (-0.0285, 0.0285)]
    screw = [
        rod((0.0, -0.17, 0.05), (0.0, -0.04, 0.05), 0.014).painted(1),
        rod((-0.07, -0.16, 0.05), (0.07, -0.16, 0.05), 0.007).painted(1),
    ]
    vice = joined([*jaws, *screw, box((0.12, 0.16, 0.035), 0.008).moved(z=0.0155)])
    make_static(
        scene, place(scene, "Vice", vice, (iron, steel), BAR - Vector((0.0, 0.0, 0.16))), STEEL
    )
    blade = joined(
        (
            box((0.030, 0.34, 0.007)).moved(z=0.0035),
            rod((0.0, 0.17, 0.014), (0.0, 0.29, 0.014), 0.014, 16).painted(1),
        )
    )
    materials = (
        surface("File Steel", "#5d646b", 0.45, 0.9),
        surface("File Handle", "#a8642c", 0.5),
    )
    file = place(scene, "File", blade, materials, BAR - Vector((0.0, 0.02, SUNK)))
    make_moving(scene, file, STEEL, 0.4, "BOX")
    shoulder, elbow = (avatar.joints[f"{joint}.R"] for joint in ("shoulder", "elbow"))
    turning = place_empty(scene, "Shoulder.R", shoulder, avatar.root, size=0.06)
    following = place_empty(scene, "Elbow.R", elbow, avatar.root, size=0.06)
    for carrier, parts in ((turning, ("Upper Arm.R",)), (following, ("Forearm.R", "Hand.R"))):
        _carry(carrier, [avatar.parts[part] for part in parts])
    angles = {frame: STROKE * wave for frame, wave in _waves(*SECTIONS["File"], 4).items()}
    moved = {
        frame: Matrix.Rotation(angle, 3, "X") @ (elbow - shoulder) - (elbow - shoulder)
        for frame, angle in angles.items()
    }
    forearm = (GRIP - avatar.root.location - elbow).yz
    held = {frame: _at_height(forearm, forearm.y - way.z) for frame, way in moved.items()}
    animate(
        turning, "rotation_euler", {frame: (angle, 0.0, 0.0) for frame, angle in angles.items()}
    )
    animate(following, "location", {frame: tuple(elbow + way) for frame, way in moved.items()})
    animate(
        following,
        "rotation_euler",
        {frame: (way.angle_signed(forearm), 0.0, 0.0) for frame, way in held.items()},
    )
    strokes = {frame: way.y + held[frame].x - forearm.x for frame, way in moved.items()}
    animate(
        file,
        "location",
        {frame: tuple(file.location + Vector((0.0, y, 0.0))) for frame, y in strokes.items()},
    )


def _at_height(way: Vector, height: float) -> Vector:
    """A way (y, z), turned so that it has a height."""
    return Vector((math.copysign(math.sqrt(way.length_squared - height * height), way.x), height))


def _carry(carrier: Object, parts: list[Object]) -> None:
    for part in parts:
        part.location -= carrier.location
        part.parent = carrier


def _add_ball(scene: Scene) -> None:
    """A wooden ball that rolls to and fro on the bench, beside the left hand."""
    height = TABLE_HEIGHT + BALL - SUNK
    shape = joined(
        (
            sphere(BALL, 32, 16),
            cylinder(BALL + 0.0004, 0.012, 48).turned(math.pi / 2, "X").painted(1),
        )
    )
    ball = place(
        scene,
        "Ball",
        shape,
        (surface("Ball", "#c8452f", 0.35), surface("Ball Stripe", "#f0e6d0", 0.4)),
        (BALL_X[0], BALL_Y, height),
    )
    make_moving(scene, ball, HARDWOOD, 0.4, "SPHERE")
    first, last = SECTIONS["Ball"]
    middle = (first + last) // 2
    ways = _there(first, middle) | {
        frame: 1.0 - part for frame, part in _there(middle, last).items()
    }
    along = {frame: (BALL_X[1] - BALL_X[0]) * part for frame, part in ways.items()}
    animate(
        ball, "location", {frame: (BALL_X[0] + way, BALL_Y, height) for frame, way in along.items()}
    )
    animate(ball, "rotation_euler", {frame: (0.0, way / BALL, 0.0) for frame, way in along.items()})


def _add_step(scene: Scene, avatar: Avatar) -> None:
    """The left leg scrapes the gravel with its foot, which stays level."""
    hip, ankle = (avatar.joints[f"{joint}.L"] for joint in ("hip", "ankle"))
    turning = place_empty(scene, "Hip.L", hip, avatar.root, size=0.06)
    following = place_empty(scene, "Ankle.L", ankle, avatar.root, size=0.06)
    _carry(turning, [avatar.parts[part] for part in ("Upper Leg.L", "Lower Leg.L")])
    _carry(following, [avatar.parts["Foot.L"]])
    angles = {frame: STEP * wave for frame, wave in _waves(*SECTIONS["Shoe"], 3).items()}
    animate(
        turning, "rotation_euler", {frame: (angle, 0.0, 0.0) for frame, angle in angles.items()}
    )
    places = {
        frame: hip + Matrix.Rotation(angle, 3, "X") @ (ankle - hip)
        for frame, angle in angles.items()
    }
    animate(
        following,
        "location",
        {frame: (place.x, place.y, ankle.z) for frame, place in places.items()},
    )


def _add_crate(scene: Scene) -> None:
    """A heavy crate that a winch drags over the yard; winch and rope are mere looks."""
    crate = place(
        scene,
        "Crate",
        crate_shape(CRATE),
        crate_materials(),
        (CRATE_X, CRATE_Y[0], CRATE / 2 - SUNK),
    )
    make_moving(scene, crate, SOFTWOOD, CRATE_MASS, "BOX")
    ways = {
        frame: CRATE_Y[0] + (CRATE_Y[1] - CRATE_Y[0]) * part
        for frame, part in _there(*SECTIONS["Crate"]).items()
    }
    animate(crate, "location", {frame: (CRATE_X, y, CRATE / 2 - SUNK) for frame, y in ways.items()})
    yellow, dark = (
        surface("Winch Yellow", "#e3a21a", 0.4),
        surface("Winch Iron", "#3c4046", 0.5, 0.8),
    )
    cheek = (
        prism(((-0.14, 0.0), (0.14, 0.0), (0.06, 0.30), (-0.06, 0.30)), 0.03)
        .turned(math.pi / 2, "X")
        .turned(math.pi / 2, "Z")
    )
    cheeks = [cheek.moved(x) for x in (-0.17, 0.14)]
    drum = cylinder(0.085, 0.28, 24).turned(math.pi / 2, "Y").moved(z=0.2).painted(1)
    end = CRATE_Y[1] - CRATE / 2 - 0.30
    place(
        scene,
        "Winch",
        joined([*cheeks, drum, box((0.44, 0.36, 0.02)).moved(z=0.01)]),
        (yellow, dark),
        (CRATE_X, end, 0.0),
    )
    rope = place(
        scene,
        "Rope",
        rod((0.0, -0.5, 0.0), (0.0, 0.5, 0.0), 0.012),
        (surface("Rope", "#b9a27a", 0.9),),
        (CRATE_X, 0.0, 0.285),
    )
    lengths = {frame: y - CRATE / 2 - end for frame, y in ways.items()}
    animate(rope, "scale", {frame: (1.0, length, 1.0) for frame, length in lengths.items()})
    animate(
        rope,
        "location",
        {frame: (CRATE_X, end + length / 2, 0.285) for frame, length in lengths.items()},
    )


def _add_wheels(scene: Scene, steel: Material) -> None:
    """A wheelset that rolls over a short track without slipping."""
    end = YARD[0] / 2 - 0.1
    for rail in add_rails(
        scene, "Rail", surface("Rail Steel", "#7d746c", 0.35, 0.9), -end, end, height=-SUNK
    ):
        rail.location.y += TRACK_Y
    height = RAIL_HEIGHT + WHEEL - 2 * SUNK
    iron = surface("Wheel Iron", "#5a5d62", 0.4, 0.9)
    spokes = [
        box((2 * WHEEL - 0.12, 0.13, 0.04))
        .turned(k * math.pi / 3, "Y")
        .moved(y=side * 0.7525)
        .painted(1)
        for k in range(3)
        for side in (-1, 1)
    ]
    wheels = place(
        scene,
        "Wheelset",
        joined([wheelset(WHEEL), *spokes]),
        (iron, steel),
        (TRACK_X[0], TRACK_Y, height),
    )
    make_moving(scene, wheels, STEEL, 500.0)
    ways = {
        frame: (TRACK_X[1] - TRACK_X[0]) * part
        for frame, part in _there(*SECTIONS["Wheel"]).items()
    }
    animate(
        wheels,
        "location",
        {frame: (TRACK_X[0] + way, TRACK_Y, height) for frame, way in ways.items()},
    )
    animate(
        wheels, "rotation_euler", {frame: (0.0, way / WHEEL, 0.0) for frame, way in ways.items()}
    )


def _add_textures(scene: Scene) -> None:
    """Textures of the objects, with the library's values unless given here.

    Rough files have 20 teeth an inch; short corrugations of rails have 25 to 80 mm. Forces are
    those of what is moved here, by its weight.
    """
    for first, second, like, values in (
        (
            "File",
            "Bar",
            "steel",
            {"period": 0.00127, "sliding": 0.6, "noise": 0.4, "full_force": 4.0, "full_speed": 0.3},
        ),
        ("Ball", "Bench Top", "softwood", {"rolling": 0.5, "full_force": 4.0, "full_speed": 0.6}),
        ("Avatar Foot.*", "Gravel Bed", "gravel", {"full_force": 10.0, "full_speed": 0.4}),
        (
            "Crate",
            "Yard",
            "concrete",
            {"sliding": 1.0, "stick_speed": 0.4, "full_force": 600.0, "full_speed": 0.4},
        ),
        (
            "Wheelset",
            "Rail.*",
            "steel",
            {
                "period": 0.025,
                "rolling": 1.0,
                "bandwidth": 0.6,
                "full_force": 5000.0,
                "full_speed": 1.5,
            },
        ),
    ):
        add_texture(scene, "OBJECT", first, second, like, **values)


def _add_surroundings(scene: Scene) -> Object:
    """Tools on the bench and the light: nothing haptic."""
    tin, red = surface("Tin", "#5f7f8c", 0.4, 0.6), surface("Oil Can", "#b5322a", 0.35)
    can = lathe(((0.045, 0.0), (0.045, 0.07), (0.012, 0.11), (0.006, 0.20)), 20)
    place(scene, "Oil Can", can, (red,), (-0.50, -0.86, TABLE_HEIGHT))
    place(
        scene,
        "Tin",
        cylinder(0.05, 0.09, 24, 0.004).moved(z=0.045),
        (tin,),
        (-0.49, -0.56, TABLE_HEIGHT),
    )
    add_backdrop(scene, surface("Backdrop", "#6d675f", 0.9), 30.0, -9.0, 6.5, -0.17, 7.0)
    add_world(scene, "#c6c2b8", 0.35)
    add_three_point_light(scene, (0.0, 0.2, 0.9), 3.4)
    return add_camera(scene, (1.15, -4.75, 2.45), (-0.22, 0.15, 0.62), 38.0)
