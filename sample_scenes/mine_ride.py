"""The ride of the paper's study: 2 min 30 s through a mine on a cart, in six sections of 25 s.

The user sits in the cart with the ten default listeners. 15 stalactites fall; a wind blows up
through a bridge; two elves shoot with blowguns; a shock wave passes from left to right; two carts
cross, one before and one behind; nine walls are broken through. Everything moves by keys, so that
the ride is the same in every version.
"""

from __future__ import annotations

import math
from random import Random

import bpy
from bpy.types import Object, Scene
from mathutils import Matrix, Vector
from mathutils.bvhtree import BVHTree

from ..core.frozen import frozen
from .animation import BEZIER, animate
from .avatar import Avatar, build_avatar, seated
from .explosion import add_explosion
from .geometry import SUNK, Geometry, Point, box, joined, lathe, rod, sphere, superellipsoid
from .lighting import add_area_light, add_camera, add_point_light, add_sun, add_world, set_picture
from .materials import FABRIC, RIBBON, SOFTWOOD, STEEL, STONE, surface
from .mine import RAIL_FOOT_HEIGHT, add_ground, add_lamps, add_track, add_tunnel, rock_material
from .mine_cart import BACK_X, FLOOR, LEAN, SEAT_HEIGHT, Cart, add_cart, roll
from .railway import MINE_GAUGE, RAIL_HEAD, rail_shape
from .staging import (
    add_rigid_body_world,
    make_medium,
    make_moving,
    make_source,
    make_static,
    place,
    place_empty,
    place_mesh,
)

FRAME_RATE = 24
FRAMES = 3600
SPEED = 2.0  # metres per second
GRAVITY = 9.81
FULL_ENERGY = 40.0  # joules


@frozen
class Section:
    """A part of the ride, from its first to its last frame."""

    name: str
    title: str
    first: int
    last: int


SECTIONS = tuple(
    Section(name, title, 1 + 600 * k, 600 * (k + 1))
    for k, (name, title) in enumerate(
        (
            ("stalactites", "Stalactites"),
            ("bridge", "Bridge in the wind"),
            ("elves", "Elves with blowguns"),
            ("explosion", "Explosion"),
            ("carts", "Crossing carts"),
            ("walls", "Walls"),
        )
    )
)


def distance_at(frame: float) -> float:
    """Where the cart is, as its x in metres, at a frame."""
    return SPEED * (frame - 1) / FRAME_RATE


def frame_at(x: float) -> float:
    """When the cart is at ``x``."""
    return 1 + x * FRAME_RATE / SPEED


BRIDGE = (50.0, 100.0)
FRONT_CROSSING, BACK_CROSSING = 222.0, 232.0
CROSSINGS = (FRONT_CROSSING, BACK_CROSSING)

# What the nine walls are made of, in the order of the ride.
WALLS = (*(("Stone", STONE),) * 3, *(("Wood", SOFTWOOD),) * 3, *(("Ribbon", RIBBON),) * 3)
WALL_PERIOD = 62  # frames
WALL_BOTTOM, WALL_TOP, WALL_HALF_WIDTH, WALL_THICKNESS = 1.08, 2.65, 1.45, 0.35


def build(scene: Scene) -> None:
    """Fill the empty ``scene``."""
    set_picture(scene, FRAMES, FRAME_RATE)
    scene.haptics.impact_energy = "as_in_the_paper"
    scene.haptics.maximum_energy = FULL_ENERGY
    add_rigid_body_world(scene, FRAMES)
    add_ground(scene, BRIDGE, CROSSINGS)
    add_track(scene)
    add_tunnel(scene, BRIDGE, CROSSINGS)
    add_lamps(scene, BRIDGE)
    cart = add_cart(scene, "Cart", "#8a5a34", seat=True)
    ride = {1.0: 0.0, float(FRAMES): distance_at(FRAMES)}
    animate(cart.root, "location", {frame: (x, 0.0, 0.0) for frame, x in ride.items()})
    roll(cart, ride)
    posture = seated(SEAT_HEIGHT, LEAN)
    avatar = build_avatar(
        scene, posture, (BACK_X, 0.0, FLOOR), math.pi / 2, moving=True, parent=cart.root
    )
    _add_stalactites(scene)
    _add_wind(scene)
    _add_elves(scene, avatar)
    _add_shock_wave(scene, cart.root)
    _add_crossing_carts(scene)
    _add_walls(scene)
    _add_camera_and_light(scene, cart.root)


# Section 1


def _add_stalactites(scene: Scene) -> None:
    """Fifteen, of 0.4 to 6 kg, fall close to the cart and stay where they strike."""
    rock = rock_material()
    draw = Random(15)
    for number in range(1, 16):
        lands = 30 + 38 * (number - 1) + draw.randrange(8)
        length = draw.uniform(0.40, 0.95)
        radius = length * draw.uniform(0.13, 0.20)
        mass = round(0.4 * 15 ** ((length - 0.40) / 0.55), 2)
        frames = draw.randrange(15, 18)
        x = distance_at(lands) + draw.uniform(-0.6, 1.4)
        y = draw.choice((-1.0, 1.0)) * draw.uniform(0.85, 1.2)
        waist = (
            (0.0, 0.0),
            (0.12 * radius, 0.06 * length),
            (0.34 * radius, 0.35 * length),
            (0.62 * radius, 0.70 * length),
        )
        shape = lathe((*waist, (radius, 0.96 * length), (0.8 * radius, length)), 11)
        stalactite = place(
            scene,
            f"Stalactite {number:02d}",
            shape,
            (rock,),
            (x, y, -0.008),
            (0.0, 0.0, draw.uniform(0.0, 6.0)),
        )
        make_moving(scene, stalactite, STONE, mass)
        on_ground = stalactite.location.copy()
        heights = {
            lands - frames + k: GRAVITY / 2 * ((frames / FRAME_RATE) ** 2 - (k / FRAME_RATE) ** 2)
            for k in range(frames + 1)
        }
        keys = {
            float(frame): (on_ground.x, on_ground.y, on_ground.z + height)
            for frame, height in heights.items()
        }
        animate(stalactite, "location", keys)


# Section 2

AIR_TOP = FLOOR + SEAT_HEIGHT + 0.08


def _add_wind(scene: Scene) -> None:
    """Air over the chasm, up to the rider's legs, with a source that follows the cart below the
    bridge and blows now more, now less."""
    section = SECTIONS[1]
    low, high = BRIDGE
    air = place(
        scene,
        "Updraft",
        box((high - low - 6.0, 2.2, AIR_TOP + 4.0)).moved(
            (low + high) / 2, 0.0, (AIR_TOP - 4.0) / 2
        ),
        (surface("Updraft", "#bfe3f2"),),
    )
    make_medium(air, 0.35)
    wind = place_empty(scene, "Wind", (0.0, 0.0, -0.9), air, "SINGLE_ARROW", 1.0)
    enter, leave = frame_at(low + 4.5), frame_at(high - 4.5)
    ends = {frame: (distance_at(frame) - air.location.x, 0.0, -0.9) for frame in (enter, leave)}
    animate(wind, "location", ends)
    make_source(wind, "NOISE", amplitude=0.0)
    strength = {1.0: 0.0, enter: 0.0, leave: 0.0, float(FRAMES): 0.0}
    count = 12
    for k in range(1, count):
        gust = 0.55 - 0.4 * math.cos(2 * math.pi * k / 3.3) * (1.0 if k % 2 else 0.6)
        strength[enter + (leave - enter) * k / count] = min(max(gust, 0.15), 1.0)
    animate(wind, "haptics.source.amplitude", strength, BEZIER)
    _add_streaks(scene, section)


def _add_streaks(scene: Scene, section: Section) -> None:
    """Leaves that fly up past the bridge: nothing haptic."""
    draw = Random(6)
    leaf = superellipsoid((0.26, 0.12, 0.02), 0.9, 8, 5)
    materials = (surface("Leaf Gold", "#d9a441", 0.6), surface("Leaf Red", "#c4572f", 0.6))
    for number in range(1, 25):
        start = section.first + 40 + 22 * number
        x, y = (
            distance_at(start + 12) + draw.uniform(-1.5, 3.0),
            draw.choice((-1.0, 1.0)) * draw.uniform(0.8, 1.9),
        )
        flying = place(scene, f"Leaf {number}", leaf, (materials[number % 2],))
        path = {
            start + 6 * k: (
                x + 0.25 * math.sin(1.7 * k + number),
                y + 0.2 * math.cos(2.1 * k),
                -6.0 + 2.2 * k,
            )
            for k in range(8)
        }
        animate(flying, "location", path, BEZIER)
        animate(flying, "rotation_euler", {start: (0.0, 0.0, 0.0), start + 42: (9.0, 7.0, 5.0)})
        animate(
            flying,
            "scale",
            {start - 1: (0, 0, 0), start: (1, 1, 1), start + 42: (1, 1, 1), start + 43: (0, 0, 0)},
        )


# Section 3

DART_MASS, DART_RADIUS, DART_FRAMES = 0.2, 0.035, 5
VOLLEY = 120  # frames: five seconds
TARGETS = {"L": ("Upper Arm.L", "Chest"), "R": ("Upper Arm.R", "Head")}


def _add_elves(scene: Scene, avatar: Avatar) -> None:
    """An elf on either side runs along; each shoots two projectiles every five seconds."""
    section = SECTIONS[2]
    skin, hair = surface("Elf Skin", "#d9a878", 0.6), surface("Elf Hat", "#b8332b", 0.7)
    cloth, tube = surface("Elf Coat", "#3f7a44", 0.8), surface("Blowgun", "#5a3b22", 0.6)
    felt = surface("Projectile", "#f2d04a", 0.5, glow=0.4)
    mouths: dict[str, Vector] = {}
    for side, letter in ((1.0, "L"), (-1.0, "R")):
        elf = place(scene, f"Elf.{letter}", _elf(side), (skin, cloth, hair, tube))
        low, high = section.first - 24, section.last + 24
        steps = {
            frame: (_elf_x(frame), side * 2.1, 0.10 * abs(math.sin(frame / 4.0)))
            for frame in range(low, high + 1, 3)
        }
        # `place` put the origin into the middle of the figure.
        middle = elf.location.copy()
        animate(
            elf,
            "location",
            {float(frame): tuple(Vector(spot) + middle) for frame, spot in steps.items()},
        )
        mouths[letter] = Vector((0.0, side * (2.1 - 0.62), 1.16))
    number = 0
    for start in range(section.first + 60, section.last - 30, VOLLEY):
        for letter, mouth in mouths.items():
            for shot, part in enumerate(TARGETS[letter]):
                number += 1
                hit = start + 20 * shot + (9 if letter == "R" else 0)
                target = _surface_point(avatar, part, mouth + Vector((_ELF_AHEAD, 0.0, 0.0)))
                _add_dart(scene, number, felt, mouth, target, hit)


_ELF_AHEAD = 1.3


def _elf_x(frame: float) -> float:
    return distance_at(frame) + _ELF_AHEAD


def _elf(side: float) -> Geometry:
    """A small figure on the ground at the origin that aims its blowgun across the track."""
    legs = [rod((x, 0.0, 0.0), (x, 0.0, 0.42), 0.06, 10) for x in (-0.09, 0.09)]
    boots = [
        superellipsoid((0.13, 0.24, 0.12), 0.7, 12, 8).moved(x, -side * 0.05, 0.06).painted(3)
        for x in (-0.09, 0.09)
    ]
    coat = lathe(((0.24, 0.34), (0.17, 0.70), (0.13, 0.98), (0.06, 1.02)), 16).painted(1)
    head = sphere(0.155, 18, 12).moved(z=1.15)
    ears = [
        lathe(((0.05, 0.0), (0.0, 0.17)), 8)
        .turned(turn * math.pi / 2, "Y")
        .moved(turn * 0.13, 0.0, 1.17)
        for turn in (-1, 1)
    ]
    hat = lathe(((0.175, 1.22), (0.13, 1.33), (0.07, 1.50), (0.0, 1.72)), 16).painted(2)
    gun = rod((0.0, -side * 0.13, 1.13), (0.0, -side * 0.60, 1.16), 0.028, 12).painted(3)
    arms = [
        rod((x, 0.0, 0.92), (0.0, -side * 0.34, 1.12), 0.045, 10).painted(1) for x in (-0.15, 0.15)
    ]
    return joined([*legs, *boots, coat, head, *ears, hat, gun, *arms])


def _surface_point(avatar: Avatar, part: str, origin: Vector) -> Vector:
    """Where a line from ``origin`` towards the middle of a part of the body meets its surface,
    relative to the cart's root."""
    obj = avatar.parts[part]
    turn = Matrix.Rotation(math.pi / 2, 4, "Z")
    middle = avatar.root.location + (turn @ obj.location)
    towards = (middle - origin).normalized()
    mesh = obj.data
    points = [turn @ vertex.co + middle for vertex in mesh.vertices]
    tree = BVHTree.FromPolygons(points, [tuple(polygon.vertices) for polygon in mesh.polygons])
    return tree.ray_cast(origin, towards)[0]


def _add_dart(
    scene: Scene, number: int, felt: bpy.types.Material, mouth: Vector, target: Vector, hit: int
) -> None:
    """A soft ball that waits beside the elf, is shot straight, touches the moving user at frame
    ``hit`` and drops beside the track."""
    dart = place(scene, f"Projectile {number:02d}", sphere(DART_RADIUS, 14, 8), (felt,))
    make_moving(scene, dart, FABRIC, DART_MASS, "SPHERE")
    away = (mouth + Vector((_ELF_AHEAD, 0.0, 0.0)) - target).normalized()
    end = target + away * (DART_RADIUS - 0.002) + Vector((distance_at(hit), 0.0, 0.0))
    shot = hit - DART_FRAMES
    begin = mouth + Vector((_elf_x(shot), 0.0, 0.0))
    side = math.copysign(1.0, mouth.y)
    # Until then it flies along with the elf in a row with the others, so that no two touch.
    in_row = Vector((0.16 + 0.09 * (number // 2), side * 0.85, -0.35))
    waiting = SECTIONS[2].first - 24
    keys = {
        float(frame): tuple(mouth + in_row + Vector((_elf_x(frame), 0.0, 0.0)))
        for frame in (waiting, shot - 10)
    }
    keys |= {float(shot): tuple(begin), float(hit): tuple(end)}
    # It bounces off, up and ahead, over the side of the cart to the ground.
    for k in (1, 2, 4, 6, 8, 10, 12, 15, 18):
        seconds = k / FRAME_RATE
        height = max(end.z + 1.7 * seconds - GRAVITY / 2 * seconds**2, DART_RADIUS + 0.03)
        keys[float(hit + k)] = (end.x + 1.8 * SPEED * seconds, end.y + side * 1.9 * seconds, height)
    animate(dart, "location", keys)


# Section 4

FRONT_SPEED = 1.0  # metres per second
FRONT_MASS = 15.0
FRONT_REACH = 2.3
SHOCK = SECTIONS[3].first + 260  # frame of the explosion


def _add_shock_wave(scene: Scene, cart: Object) -> None:
    """An explosion at the left wall; the front of its shock wave, a haptic sheet, crosses the user
    from left to right."""
    seconds = 2 * FRONT_REACH / FRONT_SPEED
    add_explosion(scene, Vector((distance_at(SHOCK) + 3.2, 2.6, 1.2)), SHOCK)
    sheet = place(
        scene,
        "Shock Front",
        box((1.5, 0.10, 1.0)),
        (surface("Shock Front", "#ffe2b8"),),
        parent=cart,
    )
    make_moving(scene, sheet, STONE, FRONT_MASS, "BOX")
    sheet.display_type = "WIRE"
    sheet.hide_render = True
    arcs = []
    for k in range(9):
        bend = [
            (0.75 * math.sin(t), -0.25 * (1 - math.cos(t)), -0.5 + k / 8)
            for t in (math.pi / 2 * (m / 6 - 1) for m in range(13))
        ]
        arcs += [rod(bend[m], bend[m + 1], 0.012, 6) for m in range(12)]
    seen = place(
        scene,
        "Shock Arcs",
        joined(arcs),
        (surface("Shock Arcs", "#ffd9a0", 0.6, glow=2.5),),
        parent=sheet,
    )
    begin, end = float(SHOCK + 4), SHOCK + 4 + seconds * FRAME_RATE
    # Before and after it rides along at the wall, where it touches nothing.
    ends = {
        when: (0.30, side * FRONT_REACH, FLOOR + 1.18)
        for when, side in ((1.0, 1.0), (begin, 1.0), (end, -1.0))
    }
    animate(sheet, "location", ends)
    animate(
        seen, "scale", {begin - 1: (0, 0, 0), begin: (1, 1, 1), end: (1, 1, 1), end + 1: (0, 0, 0)}
    )


# Section 5

PASSING = 2.8  # metres between the middles of the carts


def _add_crossing_carts(scene: Scene) -> None:
    """One cart crosses before the user and one behind; each is a source while it rolls."""
    for name, x, frame, direction, colour in (
        ("Front Cart", FRONT_CROSSING, frame_at(FRONT_CROSSING - PASSING), 1.0, "#4f6f8a"),
        ("Back Cart", BACK_CROSSING, frame_at(BACK_CROSSING + PASSING), -1.0, "#6f7d4a"),
    ):
        _add_cross_rails(scene, name, x)
        cart = add_cart(scene, name, colour, seat=False)
        cart.root.rotation_euler = (0.0, 0.0, direction * math.pi / 2)
        _add_ore(scene, name, cart)
        reach, seconds = 7.0, 4.0
        begin, end = frame - seconds / 2 * FRAME_RATE, frame + seconds / 2 * FRAME_RATE
        way = {begin: -reach, end: reach}
        animate(cart.root, "location", {when: (x, direction * y, 0.0) for when, y in way.items()})
        roll(cart, {when: y + reach for when, y in way.items()})
        rumble = place_empty(scene, f"{name} Rumble", (0.0, 0.0, 0.0), cart.wheelsets[0], size=0.2)
        make_source(rumble, "NOISE", amplitude=0.0)
        animate(
            rumble,
            "haptics.source.amplitude",
            {1.0: 0.0, begin: 0.0, begin + 6: 1.0, end - 6: 1.0, end: 0.0},
        )


def _add_cross_rails(scene: Scene, name: str, x: float) -> None:
    """Rails along y on the ground, with gaps where those of the ride pass."""
    steel = surface(f"{name} Rail", "#7d746c", 0.35, 0.9)
    gap = (MINE_GAUGE + RAIL_HEAD) / 2
    pieces = ((-8.0, -gap - 0.10), (-gap + 0.10, gap - 0.10), (gap + 0.10, 8.0))
    for number, (low, high) in enumerate(pieces, 1):
        for side, letter in ((1.0, "L"), (-1.0, "R")):
            shape = rail_shape(high - low).turned(math.pi / 2, "Z")
            rail = place(
                scene,
                f"{name} Rail {number}.{letter}",
                shape,
                (steel,),
                (x + side * gap, low, RAIL_FOOT_HEIGHT),
            )
            make_static(scene, rail, STEEL, "BOX")


def _add_ore(scene: Scene, name: str, cart: Cart) -> None:
    """What a cart carries: nothing haptic."""
    draw = Random(len(name))
    lumps = []
    for _ in range(40):
        size = draw.uniform(0.16, 0.30)
        lump = superellipsoid((size, size, size * 0.8), 0.7, 9, 6).turned(draw.uniform(0, 3), "Z")
        lump = lump.moved(
            draw.uniform(-0.65, 0.65), draw.uniform(-0.42, 0.42), FLOOR + draw.uniform(0.2, 0.52)
        )
        lumps.append(lump.painted(draw.randrange(2)))
    materials = (
        surface(f"{name} Ore", "#5b5a5e", 0.9),
        surface(f"{name} Gold", "#d0a544", 0.35, 0.9),
    )
    place(scene, f"{name} Load", joined(lumps), materials, parent=cart.root)


# Section 6


def wall_frame(number: int) -> int:
    """When the user reaches wall ``number``, from 0 to 8: the legs first, the trunk a fifth of a
    second later."""
    return SECTIONS[5].first + 40 + WALL_PERIOD * number


def _add_walls(scene: Scene) -> None:
    """Nine haptic panels above the cart's rim, which stand still; what is seen of them breaks when
    the user comes.

    They are so thick that hands, trunk and head are in one at the same time: then it hands on to
    all what strikes one of them.
    """
    looks = {
        "Stone": surface("Wall Stone", "#8d8a86", 0.9, mottle=0.4, mottle_scale=5.0),
        "Wood": surface("Wall Wood", "#a8733c", 0.7, mottle=0.4, mottle_scale=5.0),
        "Ribbon": surface("Wall Ribbon", "#c94f6d", 0.8),
    }
    draw = Random(66)
    height = WALL_TOP - WALL_BOTTOM
    for number, (kind, substance) in enumerate(WALLS):
        x = distance_at(wall_frame(number)) + 0.04 + WALL_THICKNESS / 2
        name = f"{kind} Wall {number % 3 + 1}"
        panel = place(
            scene,
            name,
            box((WALL_THICKNESS, 2 * WALL_HALF_WIDTH, height)),
            (looks[kind],),
            (x, 0.0, WALL_BOTTOM + height / 2),
        )
        make_static(scene, panel, substance, "BOX")
        panel.display_type = "WIRE"
        panel.hide_render = True
        frame = [
            box((0.2, 0.16, 2.9), 0.02).moved(0.0, side * (WALL_HALF_WIDTH + 0.1), 1.4)
            for side in (-1, 1)
        ]
        frame.append(
            box((0.22, 2 * WALL_HALF_WIDTH + 0.5, 0.18), 0.02).moved(0.0, 0.0, WALL_TOP + 0.1)
        )
        place(
            scene,
            f"{name} Frame",
            joined(frame),
            (looks["Wood"] if kind == "Wood" else looks["Stone"],),
            (x, 0.0, 0.0),
        )
        if kind == "Ribbon":
            _add_ribbons(scene, name, looks[kind], x, wall_frame(number))
        else:
            _add_pieces(
                scene,
                name,
                looks[kind],
                x,
                wall_frame(number),
                draw,
                (6, 3) if kind == "Stone" else (9, 1),
            )


def _add_pieces(
    scene: Scene,
    name: str,
    look: bpy.types.Material,
    x: float,
    frame: int,
    draw: Random,
    counts: tuple[int, int],
) -> None:
    """Blocks or planks that fly off when the wall is hit: nothing haptic."""
    columns, rows = counts
    width, height = 2 * WALL_HALF_WIDTH / columns, (WALL_TOP - WALL_BOTTOM) / rows
    shape = box((WALL_THICKNESS, width - 0.012, height - 0.012), 0.012)
    original = place(scene, f"{name} Piece 1", shape, (look,))
    for k in range(columns * rows):
        column, row = k % columns, k // columns
        spot = Vector(
            (x, (column + 0.5) * width - WALL_HALF_WIDTH, WALL_BOTTOM + (row + 0.5) * height)
        )
        piece = place_mesh(scene, f"{name} Piece {k + 1}", original.data, spot) if k else original
        speed = Vector(
            (draw.uniform(2.2, 4.0), spot.y * 1.6 + draw.uniform(-0.4, 0.4), draw.uniform(0.2, 1.8))
        )
        spin = Vector([draw.uniform(-5, 5) for _ in range(3)])
        moves, turns = {float(frame - 1): tuple(spot)}, {float(frame - 1): (0.0, 0.0, 0.0)}
        for step in (1, 3, 5, 8, 11, 14, 18):
            seconds = step / FRAME_RATE
            z = spot.z + speed.z * seconds - GRAVITY / 2 * seconds**2
            lying = z < 0.10
            moves[float(frame - 1 + step)] = (
                spot.x + speed.x * seconds,
                spot.y + speed.y * seconds,
                max(z, 0.08),
            )
            turns[float(frame - 1 + step)] = tuple(spin * seconds)
            if lying:
                break
        animate(piece, "location", moves)
        animate(piece, "rotation_euler", turns)


def _add_ribbons(scene: Scene, name: str, look: bpy.types.Material, x: float, frame: int) -> None:
    """Strips that swing about their upper ends: nothing haptic."""
    count = 12
    width, length = 2 * WALL_HALF_WIDTH / count, WALL_TOP - WALL_BOTTOM + 0.12
    for k in range(count):
        hinge = place_empty(
            scene,
            f"{name} Hinge {k + 1}",
            (x, (k + 0.5) * width - WALL_HALF_WIDTH, WALL_TOP),
            size=0.05,
        )
        strip = box((0.012, width - 0.02, length)).moved(z=-length / 2)
        place(scene, f"{name} Strip {k + 1}", strip, (look,), parent=hinge)
        near = math.exp(-(((k + 0.5) * width - WALL_HALF_WIDTH) ** 2) / 0.35)
        swing = {frame - 2.0: 0.0, frame + 4.0: -1.25 * near, frame + 10.0: -1.1 * near}
        for n in range(1, 6):
            swing[frame + 10.0 + 8 * n] = (
                (0.5 * near + 0.05) * math.cos(math.pi * n) * math.exp(-0.5 * n)
            )
        swing[frame + 60.0] = 0.0
        animate(
            hinge,
            "rotation_euler",
            {when: (0.0, angle, 0.0) for when, angle in swing.items()},
            BEZIER,
        )


# Camera and light

# Where the camera is, relative to the cart, by section and place in it (0 to 1).
SHOTS: tuple[tuple[int, float, Point], ...] = (
    (0, 0.0, (4.2, -1.9, 2.0)),
    (0, 0.9, (4.6, -1.7, 2.3)),
    (1, 0.12, (3.6, -4.6, 2.2)),
    (1, 0.55, (5.6, -6.0, 3.2)),
    (1, 0.88, (4.0, -3.4, 2.0)),
    (2, 0.1, (4.6, -0.6, 2.4)),
    (2, 0.9, (5.0, 0.6, 2.3)),
    (3, 0.2, (4.6, -1.6, 2.1)),
    (3, 0.9, (4.2, -1.2, 2.2)),
    (4, 0.15, (-4.2, -1.4, 2.5)),
    (4, 0.42, (-4.0, -1.2, 2.6)),
    (4, 0.62, (4.6, -1.2, 2.6)),
    (4, 0.84, (4.6, -1.0, 2.4)),
    (5, 0.02, (-3.3, -1.0, 2.3)),
    (5, 1.0, (-3.0, 0.9, 2.3)),
)


def _add_camera_and_light(scene: Scene, cart: Object) -> None:
    add_world(scene, "#3d4f70", 0.7)
    add_sun(scene, "Moonlight", (0.35, 0.45, -0.8), 2.2, "#b8ccff")
    camera = add_camera(scene, SHOTS[0][2], (0.0, 0.0, 1.3), 26.0)
    camera.parent = cart
    keys = {}
    for section, part, spot in SHOTS:
        first, last = SECTIONS[section].first, SECTIONS[section].last
        keys[round(first + part * (last - first))] = spot
    animate(camera, "location", keys, BEZIER)
    target = place_empty(scene, "Camera Target", (0.15, 0.0, 1.35), cart, size=0.15)
    follow = camera.constraints.new("TRACK_TO")
    follow.target = target
    follow.track_axis, follow.up_axis = "TRACK_NEGATIVE_Z", "UP_Y"
    headlight = add_point_light(scene, "Cart Lantern", (1.15, 0.0, 1.55), 70.0, 0.15, "#ffd39a")
    headlight.parent = cart
    for name, location, power, colour in (
        ("Key Light", (2.8, -2.2, 3.0), 190.0, "#ffe2bd"),
        ("Rim Light", (-2.6, 1.6, 2.9), 150.0, "#9fc4ff"),
    ):
        light = add_area_light(scene, name, location, (0.0, 0.0, 1.3), power, 1.0, colour)
        light.parent = cart
    lantern = joined(
        (
            box((0.14, 0.14, 0.03)).moved(z=0.13),
            box((0.14, 0.14, 0.03)).moved(z=-0.13),
            sphere(0.07, 14, 8).painted(1),
        )
    )
    pole = rod((-0.26, 0.0, -0.55), (-0.10, 0.0, 0.2), 0.018, 8) + rod(
        (-0.10, 0.0, 0.2), (0.0, 0.0, 0.14), 0.014, 8
    )
    iron, glow = (
        surface("Cart Lantern Iron", "#2c2a26", 0.6),
        surface("Cart Lantern Glow", "#ffcf87", 0.5, glow=12.0),
    )
    place(
        scene,
        "Lantern",
        joined((lantern, pole)),
        (iron, glow),
        (1.12, 0.45, 1.5 - SUNK),
        parent=cart,
    )
