"""The mine that the ride leads through along +X: rock underfoot, rails, a bridge over a chasm, the
tunnel, lamps."""

from __future__ import annotations

import math
from collections.abc import Callable
from random import Random

from bpy.types import Material, Scene
from mathutils import Vector, noise

from .geometry import SUNK, Geometry, box, joined, lathe, rod, superellipsoid
from .lighting import add_point_light
from .materials import SOFTWOOD, STONE, surface
from .railway import MINE_GAUGE, RAIL_TOP, SLEEPER, add_rails
from .staging import make_static, place

SEGMENT = 10.0  # length of a piece of ground, and of a rail
START, END = -10.0, 320.0
WIDTH, WIDE = 7.0, 17.0
THICKNESS = 0.6
RAIL_FOOT_HEIGHT = -SUNK
TOP_OF_RAIL = RAIL_TOP - SLEEPER[2] + SUNK

TUNNEL_REACH, TUNNEL_HEIGHT = 3.3, 3.9
RING_SPACING, RING_POINTS = 1.25, 18
SIDE_HALF_WIDTH, SIDE_HEIGHT = 1.7, 2.5  # of the tunnels that cross


def add_ground(scene: Scene, bridge: tuple[float, float], crossings: tuple[float, ...]) -> None:
    """Rock in pieces that touch end to end, planks between ``bridge`` low and high x, wider rock
    where other tracks cross."""
    rock = surface("Mine Floor", "#6d6258", 0.95, mottle=0.45, mottle_scale=1.6)
    planks = (
        surface("Bridge Planks", "#7d5c3c", 0.8, mottle=0.4, mottle_scale=3.0),
        surface("Bridge Beams", "#4f3826", 0.85),
    )
    count = round((END - START) / SEGMENT)
    for number in range(count):
        low = START + number * SEGMENT
        middle = low + SEGMENT / 2
        if bridge[0] <= middle <= bridge[1]:
            deck = place(scene, f"Bridge {number + 1:02d}", _deck(), planks, (middle, 0.0, 0.0))
            make_static(scene, deck, SOFTWOOD, "BOX")
            continue
        wide = any(low - 2.0 <= x <= low + SEGMENT + 2.0 for x in crossings)
        slab = box((SEGMENT + SUNK, WIDE if wide else WIDTH, THICKNESS)).moved(z=-THICKNESS / 2)
        ground = place(scene, f"Ground {number + 1:02d}", slab, (rock,), (middle, 0.0, 0.0))
        make_static(scene, ground, STONE, "BOX")


def _deck() -> Geometry:
    """Planks on two beams; it fills a box from z = -0.3 to 0."""
    length, width = SEGMENT + SUNK, 2.6
    planks = [
        box((0.30, width, 0.07), 0.01).moved((k + 0.5) * length / 32 - length / 2, 0.0, -0.035)
        for k in range(32)
    ]
    beams = [box((length, 0.25, 0.24)).moved(0.0, y, -0.18).painted(1) for y in (-0.8, 0.8)]
    return joined([*planks, *beams])


def add_track(scene: Scene) -> None:
    """Rails in pieces that touch end to end, on the ground; sleepers, which are nothing haptic."""
    steel = surface("Rail Steel", "#8a7f76", 0.35, 0.9)
    for number in range(round((END - START) / SEGMENT)):
        low = START + number * SEGMENT
        add_rails(
            scene,
            f"Rail {number + 1:02d}",
            steel,
            low,
            low + SEGMENT + SUNK,
            MINE_GAUGE,
            RAIL_FOOT_HEIGHT,
        )
    sleeper = box((0.2, 1.5, 0.06), 0.012)
    sleepers = joined(sleeper.moved(START + 0.5 + k, 0.0, 0.005) for k in range(round(END - START)))
    place(scene, "Sleepers", sleepers, (surface("Sleeper", "#4a3829", 0.9),))


def add_tunnel(scene: Scene, bridge: tuple[float, float], crossings: tuple[float, ...]) -> None:
    """Rough rock around the track, open over the chasm and where tunnels cross."""
    rock = surface("Rock", "#6a5f59", 0.95, mottle=0.5, mottle_scale=0.8)

    def opened(x: float, y: float, z: float) -> bool:
        return any(
            abs(x - crossing) < SIDE_HALF_WIDTH + 0.3 and z < SIDE_HEIGHT + 0.3 and abs(y) > 1.5
            for crossing in crossings
        )

    for name, low, high in (
        ("Tunnel 1", START, bridge[0] + 1.0),
        ("Tunnel 2", bridge[1] - 1.0, END),
    ):
        place(scene, name, _tube(low, high, TUNNEL_REACH, TUNNEL_HEIGHT, opened), (rock,))
    for number, crossing in enumerate(crossings, 1):
        for side, letter in ((1.0, "L"), (-1.0, "R")):
            tube = _tube(0.0, 7.5, SIDE_HALF_WIDTH + 0.2, SIDE_HEIGHT + 0.2, lambda x, y, z: False)
            branch = tube.turned(side * math.pi / 2, "Z").moved(crossing, side * 2.4, 0.0)
            place(scene, f"Side Tunnel {number}.{letter}", branch, (rock,))
    for x, name in ((bridge[0] + 0.5, "Cliff 1"), (bridge[1] - 0.5, "Cliff 2")):
        place(scene, name, _cliff(x), (rock,))
    _add_chasm(scene, bridge)


def _tube(
    low: float,
    high: float,
    reach: float,
    height: float,
    opened: Callable[[float, float, float], bool],
) -> Geometry:
    """A rough arch along x from the ground on one side to that on the other; its faces look
    inwards."""
    rings = round((high - low) / RING_SPACING) + 1
    vertices = []
    for ring in range(rings):
        x = low + (high - low) * ring / (rings - 1)
        for k in range(RING_POINTS + 1):
            turn = math.pi * k / RING_POINTS
            y, z = (
                reach * math.cos(turn),
                height * math.sin(turn) ** 0.8 if 0 < k < RING_POINTS else -0.2,
            )
            rough = (
                1.0
                + 0.16 * noise.noise(Vector((0.45 * x, 0.6 * y, 0.6 * z)))
                + 0.07 * noise.noise(Vector((1.6 * x, 1.7 * y, 1.7 * z)))
            )
            vertices.append((x, y * rough, z * rough))
    faces = []
    for ring in range(rings - 1):
        for k in range(RING_POINTS):
            a = ring * (RING_POINTS + 1) + k
            corners = (a, a + RING_POINTS + 1, a + RING_POINTS + 2, a + 1)
            middle = [sum(vertices[corner][axis] for corner in corners) / 4 for axis in range(3)]
            if not opened(*middle):
                faces.append(corners)
    return Geometry(tuple(vertices), tuple(faces), (0,) * len(faces))


def _cliff(x: float) -> Geometry:
    """A face of rocks about the mouth of the tunnel, down into the chasm."""
    draw = Random(int(x))
    rocks = []
    for y in range(-13, 14, 2):
        for z in range(-15, 13, 2):
            in_mouth = abs(y) < 3.6 and -0.5 < z < 4.2
            if in_mouth:
                continue
            size = draw.uniform(2.6, 3.8)
            below = 1.6 if z < 0 and abs(y) < 4 else 0.0
            toward = below if x < 75 else -below
            rock = superellipsoid((size, size, size), 0.75, 9, 6).turned(draw.uniform(0, 3), "Z")
            rocks.append(
                rock.moved(
                    x - toward + draw.uniform(-0.7, 0.7),
                    y + draw.uniform(-0.5, 0.5),
                    z - (1.4 if z <= 0 else 0.0),
                )
            )
    return joined(rocks)


def _add_chasm(scene: Scene, bridge: tuple[float, float]) -> None:
    """Water far below, pillars of rock, ropes along the bridge."""
    low, high = bridge
    draw = Random(21)
    water = box((high - low + 30.0, 70.0, 0.1)).moved((low + high) / 2, 0.0, -15.0)
    place(scene, "Water", water, (surface("Water", "#1f6f78", 0.08, glow=0.25),))
    pillars = []
    for _ in range(26):
        x, y = draw.uniform(low - 2, high + 2), draw.choice((-1, 1)) * draw.uniform(7.0, 26.0)
        top, radius = draw.uniform(-7.0, 10.0), draw.uniform(0.8, 2.4)
        shape = lathe(
            (
                (radius * 1.5, -15.5),
                (radius, -9.0),
                (radius * 0.8, top - 1.0),
                (radius * 0.45, top),
                (0.0, top + 0.5),
            ),
            9,
        )
        pillars.append(shape.turned(draw.uniform(0, 6), "Z").moved(x, y, 0.0))
    place(
        scene,
        "Pillars",
        joined(pillars),
        (surface("Pillar Rock", "#54606b", 0.95, mottle=0.4, mottle_scale=0.7),),
    )
    posts, ropes = [], []
    spacing = 2.5
    for k in range(round((high - low) / spacing) + 1):
        x = low + spacing * k
        for y in (-1.25, 1.25):
            posts.append(rod((x, y, -0.1), (x, y, 1.0), 0.045, 8))
            if x + spacing <= high:
                steps = [
                    (x + spacing * t / 5, y, 0.95 - 0.16 * math.sin(math.pi * t / 5))
                    for t in range(6)
                ]
                ropes += [rod(steps[t], steps[t + 1], 0.02, 6).painted(1) for t in range(5)]
    place(
        scene,
        "Bridge Ropes",
        joined(posts + ropes),
        (surface("Post Wood", "#5b4029", 0.85), surface("Rope", "#b59a6a", 0.9)),
    )


def add_lamps(scene: Scene, bridge: tuple[float, float]) -> None:
    """Props of timber and lanterns along the tunnel; crystals that glow."""
    timber, iron, flame = (
        surface("Timber", "#6b4a2e", 0.85, mottle=0.35),
        surface("Lantern Iron", "#26241f", 0.6),
        surface("Lantern Flame", "#ffb347", 0.5, glow=9.0),
    )
    frames, lanterns = [], []
    places = [
        x
        for x in (START + 7.0 + 10.0 * k for k in range(32))
        if not bridge[0] - 2 < x < bridge[1] + 2
    ]
    for x in places:
        frames += [box((0.22, 0.22, 2.9), 0.02).moved(x, y, 1.45) for y in (-2.45, 2.45)]
        frames += [box((0.24, 5.2, 0.24), 0.02).moved(x, 0.0, 3.0)]
        lanterns += [
            rod((x, 1.5, 2.9), (x, 1.5, 2.65), 0.012, 6),
            box((0.13, 0.13, 0.04)).moved(x, 1.5, 2.63),
        ]
        lanterns += [superellipsoid((0.11, 0.11, 0.17), 0.8, 10, 6).moved(x, 1.5, 2.52).painted(1)]
    place(scene, "Timber Frames", joined(frames), (timber,))
    place(scene, "Lanterns", joined(lanterns), (iron, flame))
    for number, x in enumerate(places[::2], 1):
        add_point_light(scene, f"Lantern Light {number}", (x, 1.2, 2.4), 240.0, 0.15, "#ffb870")
    draw = Random(4)
    colours = (
        surface("Crystal Blue", "#3fb6e8", 0.2, glow=2.5),
        surface("Crystal Violet", "#a36bea", 0.2, glow=2.0),
    )
    crystals = [_crystal(draw, bridge) for _ in range(70)]
    place(scene, "Crystals", joined(crystals), colours)


def _crystal(draw: Random, bridge: tuple[float, float]) -> Geometry:
    x = draw.uniform(START, END)
    if bridge[0] < x < bridge[1]:
        x += bridge[1] - bridge[0]
    side, length, radius = draw.choice((-1, 1)), draw.uniform(0.25, 0.7), draw.uniform(0.04, 0.10)
    gem = lathe(((radius * 0.7, 0.0), (radius, 0.6 * length), (0.0, length)), 6).turned(
        side * draw.uniform(0.1, 0.7), "X"
    )
    return gem.moved(x, side * draw.uniform(2.6, 3.1), -0.02).painted(draw.randrange(2))


def rock_material() -> Material:
    """Of what falls from the ceiling."""
    return surface("Dripstone", "#b7a58d", 0.7, mottle=0.4, mottle_scale=6.0)
