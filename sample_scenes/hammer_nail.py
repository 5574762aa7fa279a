"""The paper's example of a temporary source: a hammer in the left hand strikes a nail in a plank on
a table."""

from __future__ import annotations

import math

from bpy.types import Material, Object, Scene
from mathutils import Vector

from .animation import animate
from .avatar import Hand, build_avatar, standing
from .furniture import add_table
from .geometry import SUNK, Geometry, box, cylinder, joined, lathe, rod, superellipsoid
from .lighting import add_backdrop, add_camera, add_three_point_light, add_world, set_picture
from .materials import CONCRETE, SOFTWOOD, STEEL, surface
from .staging import add_rigid_body_world, make_moving, make_static, place, place_empty

FRAMES = 120
TABLE_HEIGHT = 0.88
PLANK = (0.70, 0.16, 0.055)
# Middle of its head's upper side, before the first blow.
NAIL = Vector((0.13, -0.60, TABLE_HEIGHT + PLANK[2] + 0.062))
NAIL_LENGTH = 0.072

STRIKES = (20, 44, 68, 92)  # frames
DEPTH_PER_STRIKE = 0.007
SWING = math.radians(58)
FALL = 5  # frames from the top of the swing to the nail
HAMMER_MASS = 1.6
FULL_ENERGY = 20.0  # joules


def build(scene: Scene) -> None:
    """Fill the empty ``scene``."""
    set_picture(scene, FRAMES)
    scene.haptics.maximum_energy = FULL_ENERGY
    add_rigid_body_world(scene, FRAMES)
    wood = surface("Table Wood", "#a9743f", 0.55, mottle=0.35, mottle_scale=7.0)
    steel = surface("Bare Steel", "#aeb4ba", 0.28, 1.0)
    floor = place(
        scene,
        "Floor",
        _floor(),
        (surface("Boards", "#7d6a55", 0.7, mottle=0.3), surface("Joists", "#4d4238", 0.8)),
    )
    make_static(scene, floor, CONCRETE, "BOX")
    add_table(
        scene,
        "Table",
        (0.0, -0.70, 0.0),
        wood,
        surface("Table Legs", "#6d4a2a", 0.6),
        size=(1.45, 0.62),
        height=TABLE_HEIGHT,
    )
    fresh = surface("Fresh Wood", "#d9b27c", 0.6, mottle=0.25)
    plank = place(
        scene,
        "Plank",
        box(PLANK, 0.004),
        (fresh,),
        (0.02, NAIL.y, TABLE_HEIGHT + PLANK[2] / 2 - SUNK),
    )
    make_static(scene, plank, SOFTWOOD, "BOX")
    _add_nail(scene, steel)
    _add_carpenter(scene, steel)
    _add_things_on_the_table(scene, steel)
    _add_surroundings(scene)


def _floor() -> Geometry:
    width, depth = 3.0, 2.3
    boards = [
        box((0.246, depth, 0.03), 0.004).moved((k + 0.5) * 0.25 - width / 2, 0.0, -0.015)
        for k in range(12)
    ]
    return joined([*boards, box((width, depth, 0.12)).moved(z=-0.09).painted(1)])


def _add_nail(scene: Scene, steel: Material) -> None:
    """The nail sinks by a centimetre in the frame after each blow."""
    shape = lathe(
        (
            (0.0008, -NAIL_LENGTH),
            (0.0035, -NAIL_LENGTH + 0.012),
            (0.0035, -0.004),
            (0.010, -0.004),
            (0.010, 0.0),
        ),
        16,
    )
    nail = place(scene, "Nail", shape, (steel,), NAIL)
    make_static(scene, nail, STEEL)
    start = nail.location.copy()
    heights: dict[float, float] = {1.0: start.z}
    for number, frame in enumerate(STRIKES, 1):
        heights[frame] = start.z - (number - 1) * DEPTH_PER_STRIKE
        heights[frame + 1] = start.z - number * DEPTH_PER_STRIKE
    animate(nail, "location", {frame: (start.x, start.y, z) for frame, z in heights.items()})


def _add_carpenter(scene: Scene, steel: Material) -> None:
    """The avatar with the hammer; forearm, hand and hammer swing about the left elbow."""
    handle = Vector((NAIL.x, NAIL.y, NAIL.z + 0.055))
    grip = handle + Vector((0.0, 0.285, 0.0))
    inwards = Vector((-1.0, 0.0, 0.0))
    left = Hand(grip - inwards * (0.016 - 0.001), Vector((0.0, -1.0, -0.35)), -inwards)
    right = Hand(
        Vector((-0.20, NAIL.y + 0.02, TABLE_HEIGHT + PLANK[2] - 2 * SUNK)),
        Vector((0.35, -1.0, -0.12)),
    )
    avatar = build_avatar(scene, standing(left, right), moving=True)
    hammer = place(
        scene, "Hammer", _hammer(), (surface("Ash Handle", "#b98a52", 0.5), steel), handle
    )
    make_moving(scene, hammer, STEEL, HAMMER_MASS)
    fingers = place(
        scene, "Fingers.L", _curled_fingers(), tuple(avatar.parts["Hand.L"].data.materials), grip
    )
    elbow = place_empty(scene, "Elbow.L", avatar.joints["elbow.L"], avatar.root, size=0.06)
    for obj in (avatar.parts["Forearm.L"], avatar.parts["Hand.L"], hammer, fingers):
        obj.location -= elbow.location
        obj.parent = elbow
    animate(elbow, "rotation_euler", _swing((handle - avatar.joints["elbow.L"]).length))


def _swing(reach: float) -> dict[float, tuple[float, float, float]]:
    """The elbow's rotation by frame; 0 is the hammer on the nail as it stands before the first
    blow."""
    angles: dict[float, float] = {1.0: -SWING}
    for number, frame in enumerate(STRIKES):
        before, after = (
            math.asin((blows * DEPTH_PER_STRIKE + SUNK) / reach) for blows in (number, number + 1)
        )
        for k in range(FALL + 1):
            angles[frame - FALL + k] = before - (SWING + before) * (1 - (k / FALL) ** 2)
        angles[frame + 1] = after
        angles[frame + 3] = after - math.radians(6)
        angles[frame + 14] = -SWING
    angles[float(FRAMES)] = -SWING
    return {frame: (angle, 0.0, 0.0) for frame, angle in angles.items()}


def _hammer() -> Geometry:
    """A club hammer: its head about the origin, face down, the handle along +Y."""
    head = joined(
        (
            box((0.042, 0.042, 0.07), 0.006),
            cylinder(0.024, 0.022, 20, 0.003).moved(z=-0.044),
            cylinder(0.024, 0.022, 20, 0.003).moved(z=0.044),
        )
    ).painted(1)
    handle = rod((0.0, -0.024, 0.0), (0.0, 0.345, 0.0), 0.013, 16)
    grip = rod((0.0, 0.22, 0.0), (0.0, 0.347, 0.0), 0.016, 16)
    return joined((head, handle, grip))


def _curled_fingers() -> Geometry:
    """What closes the left hand about the handle: nothing haptic."""
    fingers = [
        superellipsoid((0.030, 0.026, 0.072), 0.7, 14, 8).moved(-0.030, 0.030 * (k - 1.5), -0.008)
        for k in range(4)
    ]
    knuckles = [
        superellipsoid((0.075, 0.026, 0.030), 0.7, 14, 8).moved(-0.006, 0.030 * (k - 1.5), -0.034)
        for k in range(4)
    ]
    thumb = superellipsoid((0.065, 0.026, 0.026), 0.7, 14, 8).moved(-0.008, -0.030, 0.030)
    return joined([*fingers, *knuckles, thumb])


def _add_things_on_the_table(scene: Scene, steel: Material) -> None:
    """A box of nails, a pencil, a try square: nothing haptic."""
    tray = joined(
        [box((0.18, 0.12, 0.008)).moved(z=0.004)]
        + [box((0.18, 0.006, 0.04)).moved(0.0, y, 0.02) for y in (-0.057, 0.057)]
        + [box((0.006, 0.12, 0.04)).moved(x, 0.0, 0.02) for x in (-0.087, 0.087)]
    )
    nails = joined(
        rod(
            (-0.05, 0.01 * k - 0.045, 0.013),
            (0.04, 0.009 * k - 0.04, 0.013 + 0.002 * (k % 3)),
            0.0035,
            8,
        )
        for k in range(10)
    )
    square = joined(
        (
            box((0.03, 0.16, 0.018), 0.003),
            box((0.24, 0.03, 0.004)).moved(0.13, 0.065, 0.0).painted(1),
        )
    )
    pencil = rod((0.0, 0.0, 0.0), (0.17, 0.0, 0.0), 0.004, 6)
    tin, rosewood = surface("Tin", "#5f7f8c", 0.4, 0.6), surface("Rosewood", "#5a2c1d", 0.4)
    yellow = surface("Pencil Yellow", "#e3a21a", 0.4)
    for name, shape, materials, (x, y, rise), turn in (
        ("Box of Nails", joined((tray, nails.painted(1))), (tin, steel), (0.50, -0.70, 0.0), -18),
        ("Try Square", square, (rosewood, steel), (-0.58, -0.78, 0.009), 25),
        ("Pencil", pencil, (yellow,), (0.18, -0.88, 0.004), 14),
    ):
        place(
            scene,
            name,
            shape,
            materials,
            (x, y, TABLE_HEIGHT + rise),
            (0.0, 0.0, math.radians(turn)),
        )


def _add_surroundings(scene: Scene) -> Object:
    add_backdrop(scene, surface("Backdrop", "#6d675f", 0.9), 30.0, -9.0, 6.0, -0.15, 7.0)
    add_world(scene, "#c6c2b8", 0.3)
    add_three_point_light(scene, (0.0, -0.3, 1.0), 3.0)
    return add_camera(scene, (-1.9, -4.9, 2.1), (0.0, -0.35, 0.82), 42.0)
