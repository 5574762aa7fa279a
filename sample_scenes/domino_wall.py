"""A thousand impacts: dominoes in a spiral of four arms, each felled by the one before, felt
through the ground on a bench.

``count`` dominoes fell ``count - ARMS`` others; some strike the foot of the next once more as they
come to lie on it, and the last ones strike the ground.
"""

from __future__ import annotations

import colorsys
import math

from bpy.types import Material, Object, Scene

from .avatar import TURNED_UP, build_avatar, seated
from .furniture import add_bench
from .geometry import Point, box, to_mesh
from .lighting import add_backdrop, add_camera, add_three_point_light, add_world, set_picture
from .materials import CONCRETE, HARDWOOD, surface
from .staging import add_rigid_body_world, make_dynamic, make_static, place, place_mesh

COUNT = 1000
ARMS = 4
FRAME_RATE = 60  # a domino falls onto the next within a twentieth of a second
DOMINO: Point = (0.035, 0.12, 0.24)  # along the fall, across, up
MASS = 0.6
SPACING = 0.11
ARM_SPACING = 0.33
INNER_RADIUS = 0.55
FIRST_TILT = math.radians(10.5)  # beyond its balance, short of the second
LEAST_ENERGY, FULL_ENERGY = 0.0005, 0.1  # joules
FRAMES_PER_DOMINO = 2.7
COLOURS = 12
SEAT_HEIGHT, LEAN = 0.45, math.radians(10)


def build(scene: Scene, count: int = COUNT) -> None:
    """Fill the empty ``scene`` with ``count`` dominoes, a multiple of four."""
    frames = FRAME_RATE + math.ceil(FRAMES_PER_DOMINO * count / ARMS)
    set_picture(scene, frames, FRAME_RATE)
    haptics = scene.haptics
    haptics.minimum_energy, haptics.maximum_energy = LEAST_ENERGY, FULL_ENERGY
    add_rigid_body_world(scene, frames)
    arm = spiral(count // ARMS)
    radius = math.hypot(*arm[0][:2])
    _add_ground(scene, radius)
    _add_dominoes(scene, arm)
    bench = (0.0, radius + 1.05, 0.0)
    wood, metal = (
        surface("Bench Wood", "#b9804a", 0.55, mottle=0.35, mottle_scale=9.0),
        surface("Dark Metal", "#33383d", 0.4, 0.8),
    )
    add_bench(scene, bench, wood, metal, height=SEAT_HEIGHT, lean=LEAN)
    build_avatar(scene, seated(SEAT_HEIGHT, LEAN), bench, gain=TURNED_UP)
    _add_surroundings(scene, radius)


def spiral(count: int) -> list[tuple[float, float, float]]:
    """Where the dominoes of the first arm stand and which way they fall (x, y, angle), from the
    outer end inwards, at equal distances."""
    growth = ARMS * ARM_SPACING / (2 * math.pi)
    turn = INNER_RADIUS / growth
    inwards = []
    for _ in range(count):
        radius = growth * turn
        # Against the tangent of the spiral r = growth * turn.
        along = turn - math.pi / 2 - math.atan(growth / radius)
        inwards.append((radius * math.cos(turn), radius * math.sin(turn), along))
        turn += SPACING / math.hypot(radius, growth)
    # Turned so that the arm starts in front, to the left.
    return [_turned(place, -turn - 2.4) for place in reversed(inwards)]


def _turned(place: tuple[float, float, float], angle: float) -> tuple[float, float, float]:
    x, y, along = place
    cosine, sine = math.cos(angle), math.sin(angle)
    return (x * cosine - y * sine, x * sine + y * cosine, along + angle)


def _add_ground(scene: Scene, radius: float) -> Object:
    width, front, back = 2 * radius + 1.0, -radius - 0.5, radius + 1.6
    slab = box((width, back - front, 0.2), 0.03).moved(0.0, (front + back) / 2, -0.1)
    ground = place(scene, "Ground", slab, (surface("Stage", "#9b9da3", 0.5, mottle=0.08),))
    return make_static(scene, ground, CONCRETE, "BOX")


def _add_dominoes(scene: Scene, arm: list[tuple[float, float, float]]) -> None:
    """``Domino A001`` is the first of the first arm."""
    meshes = [to_mesh(f"Domino {k + 1}", box(DOMINO, 0.004), (_colour(k),)) for k in range(COLOURS)]
    for letter in range(ARMS):
        for number, (x, y, along) in enumerate(
            (_turned(spot, 2 * math.pi * letter / ARMS) for spot in arm), 1
        ):
            mesh = meshes[(3 * letter + number // 12) % COLOURS]
            tilt = FIRST_TILT if number == 1 else 0.0
            name = f"Domino {chr(ord('A') + letter)}{number:03d}"
            domino = place_mesh(scene, name, mesh, _standing(x, y, along, tilt), (0.0, tilt, along))
            make_dynamic(scene, domino, HARDWOOD, MASS, "BOX", friction=0.4, restitution=0.0)
            domino.rigid_body.use_deactivation = True
            domino.rigid_body.use_start_deactivated = number > 1


def _standing(x: float, y: float, along: float, tilt: float) -> Point:
    """The middle of a domino that stands on the ground, tilted forward about its lower front
    edge."""
    half_thickness, half_height = DOMINO[0] / 2, DOMINO[2] / 2
    forward = half_thickness - half_thickness * math.cos(tilt) + half_height * math.sin(tilt)
    up = half_thickness * math.sin(tilt) + half_height * math.cos(tilt)
    return (x + forward * math.cos(along), y + forward * math.sin(along), up)


def _colour(number: int) -> Material:
    channels = colorsys.hsv_to_rgb(number / COLOURS, 0.62, 0.86)
    return surface(
        f"Domino Colour {number + 1}",
        "#" + "".join(f"{round(255 * channel):02x}" for channel in channels),
        0.35,
    )


def _add_surroundings(scene: Scene, radius: float) -> Object:
    size = radius + 1.0
    add_backdrop(
        scene,
        surface("Backdrop", "#4c5560", 0.95),
        16 * size,
        -5 * size,
        3.2 * size,
        -0.2,
        3 * size,
    )
    add_world(scene, "#c3cad6", 0.35)
    add_three_point_light(scene, (0.0, 0.3, 0.2), 1.35 * size)
    return add_camera(
        scene, (-0.35 * size, -2.05 * size, 1.45 * size), (0.0, 0.12 * size, 0.05 * size), 40.0
    )
