"""A driver in a kart as imported: seat, frame and steering wheel pass on the engine, the ribs of a
kerb and a bed of setts."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from random import Random

from bpy.types import Material, Object, Scene
from mathutils import Matrix, Vector

from .animation import animate
from .avatar import HIPS, Hand, Posture, trunk_frame
from .geometry import (
    SUNK,
    Geometry,
    Point,
    box,
    cylinder,
    joined,
    lathe,
    prism,
    rod,
    superellipsoid,
    torus,
)
from .lighting import add_camera, add_sun, add_world, set_picture
from .materials import surface
from .real_content import (
    add_character,
    add_instance,
    add_listeners,
    add_source,
    make_haptic,
    to_collection,
)
from .staging import add_rigid_body_world, give_mass, place, place_empty

FRAMES = 120
STEP = 0.075  # metres a frame: 1.8 m/s
START = 0.6  # y of the kart one frame before the first
WHEEL, TREAD = 0.14, 0.12
AXLES = {"F": -0.60, "R": 0.48}
TRACK = {"L": 0.52, "R": -0.52}
MASS, FULL_ENERGY = 6.0, 2.0  # of a wheel [kg], of its hardest blow, on the kerb [J]
RAIL, RAIL_X = 0.018, 0.30
PAN_TOP, SEAT_TOP = 0.125, 0.165
LEAN = math.radians(22)
STEERING, TILT = Vector((0.0, -0.36, 0.575)), math.radians(40)
STONES, STONE_STEP, FIRST_STONE = 8, 0.42, -1.4
STONE_BASE, STONE_TOP, STONE_HEIGHT, STONE_WIDTH = 0.18, 0.12, 0.022, 0.56
SETT, CHAMFER = (0.18, 0.18, 0.09), 0.012
ROWS, COLUMNS, SETT_STEP, FIRST_SETT = 13, 9, 0.2, -5.2

TOLD = {"CarPaint_Red": "plastic"}
"""What the names of Blender materials do not tell by themselves."""


def build(scene: Scene) -> None:
    """Fill the empty ``scene``."""
    set_picture(scene, FRAMES)
    scene.haptics.maximum_energy = FULL_ENERGY
    add_rigid_body_world(scene, FRAMES)
    setts = _sett_places()
    track = [*_add_track(scene), *_add_kerb(scene), _add_setts(scene, setts)]
    root = place_empty(scene, "Kart_Root", kind="ARROWS", size=0.3)
    steel, red = (
        surface("Steel_Black", "#23272b", 0.35, 0.8),
        surface("CarPaint_Red", "#c0271d", 0.2),
    )
    kart = [*_add_chassis(scene, root, steel, red), *_add_controls(scene, root, steel)]
    engine = _add_engine(scene, root)
    wheels = _add_wheels(scene)
    armature, driver = add_character(scene, "Driver", _posture(), parent=root)
    _add_helmet(scene, root)
    make_haptic(scene, [*track, *kart, *engine, *wheels.values()], TOLD)
    add_listeners(scene, armature, driver)
    add_source(engine[0])
    camera = _add_surroundings(scene)
    _drive(root, wheels, camera, setts)


def _add_track(scene: Scene) -> list[Object]:
    """Asphalt before and behind the setts, and the sand below these."""
    asphalt = surface("Asphalt_Old", "#54565a", 0.9, mottle=0.3, mottle_scale=20.0)
    sand = surface("Sand_Washed", "#b59f74", 0.95, mottle=0.3, mottle_scale=30.0)
    ends = (3.0, FIRST_SETT + SETT_STEP / 2, FIRST_SETT - (ROWS - 0.5) * SETT_STEP, -13.0)
    slabs = [
        place(
            scene,
            f"Track_Segment_{number:02}",
            box((3.2, near - far, 0.1)).moved(0.0, (near + far) / 2, -0.05),
            (asphalt,),
        )
        for number, (near, far) in enumerate((ends[:2], ends[2:]), 1)
    ]
    middle, length = (ends[1] + ends[2]) / 2, ends[1] - ends[2]
    bed = box((3.2, length, 0.2)).moved(0.0, middle, -0.083 - 0.1)
    return [*slabs, place(scene, "Bedding_low", bed, (sand,))]


def _add_kerb(scene: Scene) -> list[Object]:
    """The stones of a kerb, red and white in turn, two blocks that instances show."""
    half, top = STONE_BASE / 2, STONE_TOP / 2
    outline = ((-half, 0.0), (half, 0.0), (top, STONE_HEIGHT), (-top, STONE_HEIGHT))
    stone = prism(outline, STONE_WIDTH)
    # Drawn out along x instead of z, without the rounding of a turn.
    lying = replace(stone, vertices=tuple((along, y, z) for y, z, along in stone.vertices))
    shape = lying.moved(-STONE_WIDTH / 2)
    stones, blocks = [], []
    for name, colour in (("Red", "#b3241c"), ("White", "#e6e4dd")):
        obj = place(scene, f"Kerbstone_{name}", shape, (surface(f"Concrete_{name}", colour, 0.7),))
        stones.append(obj)
        blocks.append(to_collection(f"Block_Kerb_{name}", [obj]))
    for number, y in enumerate(_stone_places()):
        add_instance(scene, blocks[number % 2], f"Kerb_{number + 1:02}", (TRACK["R"], y, -SUNK))
    return stones


def _stone_places() -> list[float]:
    return [FIRST_STONE - number * STONE_STEP for number in range(STONES)]


def _sett_places() -> list[Point]:
    """The middles of the setts' upper sides, no two at one height."""
    draw = Random(3)
    return [
        (
            (column - (COLUMNS - 1) / 2) * SETT_STEP,
            FIRST_SETT - row * SETT_STEP,
            draw.uniform(-0.006, 0.004),
        )
        for row in range(ROWS)
        for column in range(COLUMNS)
    ]


def _add_setts(scene: Scene, places: list[Point]) -> Object:
    """Granite setts, one mesh instanced on the vertices of another."""
    granite = surface("Granite_Sett", "#8f8c88", 0.75, mottle=0.35, mottle_scale=25.0)
    sett = place(scene, "Sett_A", box(SETT, CHAMFER), (granite,))
    bed = place(scene, "Setts_Scatter", Geometry(tuple(places), (), ()), ())
    bed.instance_type = "VERTS"
    sett.parent, sett.location = bed, (0.0, 0.0, -SETT[2] / 2)
    return sett


def _posture() -> Posture:
    """Low in the seat, feet on the pan, hands at nine and three."""
    up = Matrix.Rotation(-TILT, 3, "X") @ Vector((0.0, -1.0, 0.0))
    hand = Hand(STEERING + Vector((0.160, 0.0, 0.0)), up, Vector((1.0, 0.0, 0.0)))
    return Posture(
        hips=Vector((0.0, 0.0, SEAT_TOP + HIPS[2] / 2 - SUNK)),
        hip_joint=Vector((0.088, -0.105, -0.017)),
        knee=Vector((0.135, -0.44, 0.45)),
        ankle=Vector((0.115, -0.76, PAN_TOP + 0.102 - SUNK)),
        hand=hand,
        lean=LEAN,
    )


def _add_chassis(scene: Scene, root: Object, steel: Material, red: Material) -> list[Object]:
    """Tubes, pan, bodywork, seat and axles."""
    rails = [rod((x, 0.68, WHEEL), (x, -1.02, WHEEL), RAIL) for x in (-RAIL_X, RAIL_X)]
    across = [
        rod((-RAIL_X, y, WHEEL), (RAIL_X, y, WHEEL), RAIL)
        for y in (0.66, 0.12, -0.15, -0.50, -0.76, -1.0)
    ]
    seat_lean = Matrix.Rotation(-LEAN, 4, "X")
    back = trunk_frame(_posture())(0.0, -(0.1125 + 0.01 - SUNK), 0.36)
    seat = [
        box((0.40, 0.38, 0.02), 0.006).moved(0.0, -0.03, SEAT_TOP - 0.01),
        box((0.40, 0.02, 0.19), 0.006).moved(0.0, 0.155, 0.235),
        box((0.40, 0.02, 0.52), 0.006).transformed(Matrix.Translation(back) @ seat_lean),
        *(box((0.02, 0.36, 0.14), 0.006).moved(x, -0.02, 0.215) for x in (-0.2, 0.2)),
    ]
    pod = superellipsoid((0.18, 0.44, 0.16), 0.4)
    bumper = [
        rod((-0.5, 0.70, 0.16), (0.5, 0.70, 0.16), 0.02, 16),
        *(rod((x, 0.62, WHEEL), (x, 0.70, 0.16), 0.014) for x in (-RAIL_X, RAIL_X)),
    ]
    alloy, grey = (
        surface("Alu_Sheet", "#b4b9be", 0.35, 1.0),
        surface("Leather_Seat", "#2b2523", 0.6),
    )
    shapes: dict[str, tuple[Geometry, Material]] = {
        "Chassis_low.001": (joined([*rails, *across]), steel),
        "Floorpan.002": (box((0.58, 0.92, 0.006)).moved(0.0, -0.54, PAN_TOP - 0.003), alloy),
        "Seat_Bucket": (joined(seat), grey),
        "Bumper_rear.001": (joined(bumper), steel),
        "Axle_Rear": (
            rod((TRACK["R"], AXLES["R"], WHEEL), (TRACK["L"], AXLES["R"], WHEEL), 0.016),
            steel,
        ),
        "Nose.004": (superellipsoid((0.72, 0.32, 0.15), 0.45).moved(0.0, -1.14, 0.14), red),
        "Sidepod_L.003": (pod.moved(0.40, -0.20, 0.14), red),
        "Sidepod_R.003": (pod.moved(-0.40, -0.20, 0.14), red),
    }
    for side, x in TRACK.items():
        spindle = rod((x * 0.5, AXLES["F"], WHEEL), (x, AXLES["F"], WHEEL), 0.014)
        shapes[f"Spindle_F{side}"] = spindle, steel
    return [
        place(scene, name, shape, (material,), parent=root)
        for name, (shape, material) in shapes.items()
    ]


def _add_controls(scene: Scene, root: Object, steel: Material) -> list[Object]:
    """Steering wheel, its column, pedals, tank and number plate."""
    spokes = [
        rod((0.0, 0.0, 0.0), (0.15 * math.cos(turn), 0.15 * math.sin(turn), 0.0), 0.008)
        for turn in (0.0, math.pi, math.pi / 2)
    ]
    grip = joined([torus(0.15, 0.014).painted(1), *spokes, cylinder(0.03, 0.03)])
    plastic = surface("Plastic_White", "#e9e9e4", 0.4)
    wheel = place(
        scene,
        "SteeringWheel",
        grip,
        (steel, surface("Rubber_Grip", "#1c1c1e", 0.8)),
        STEERING,
        (-TILT, 0.0, 0.0),
        root,
    )
    foot = Vector((0.0, -0.76, WHEEL))
    column = place(
        scene, "Steering_Column", rod(tuple(foot), tuple(STEERING), 0.011), (steel,), parent=root
    )
    pedals = [
        place(
            scene,
            f"Pedal_{side}",
            joined(
                (
                    box((0.07, 0.012, 0.13), 0.004).moved(x, -0.964, 0.195),
                    rod((x, -0.968, 0.12), (x, -0.968, 0.2), 0.007),
                )
            ),
            (steel,),
            parent=root,
        )
        for side, x in (("L", 0.115), ("R", -0.115))
    ]
    tank = superellipsoid((0.15, 0.2, 0.15), 0.5).moved(0.0, -0.32, PAN_TOP + 0.073)
    plate = box((0.24, 0.012, 0.22), 0.004).turned(math.radians(-25), "X")
    along = foot.lerp(STEERING, 0.5)
    return [
        wheel,
        column,
        *pedals,
        place(scene, "Fueltank.001", tank, (plastic,), parent=root),
        place(scene, "Numberplate", plate, (plastic,), tuple(along), parent=root),
    ]


def _add_engine(scene: Scene, root: Object) -> list[Object]:
    """An engine on a plate on the right rail, and its exhaust."""
    cast, sheet = (
        surface("Alu_Cast", "#9a9fa3", 0.5, 0.9),
        surface("Steel_Sheet", "#6d6a66", 0.4, 0.9),
    )
    fins = [box((0.15, 0.15, 0.008), 0.003).moved(z=0.135 + 0.018 * level) for level in range(5)]
    block = joined(
        (
            box((0.17, 0.22, 0.12), 0.02).moved(z=0.06),
            cylinder(0.055, 0.12).moved(z=0.16),
            *fins,
            cylinder(0.05, 0.05).turned(math.pi / 2, "Y").moved(-0.10, 0.0, 0.06),
        )
    )
    at = (-0.37, 0.20, 0.166 - SUNK)
    muffler = [
        rod(a, b, 0.017, 16)
        for a, b in pairwise(((-0.37, 0.26, 0.24), (-0.37, 0.36, 0.27), (-0.40, 0.44, 0.30)))
    ]
    can = rod((-0.40, 0.40, 0.31), (-0.40, 0.74, 0.31), 0.04, 20)
    return [
        place(scene, "Engine_Block.003", block, (cast,), at, parent=root),
        place(
            scene,
            "Engine_Mount",
            box((0.22, 0.26, 0.014)).moved(-0.37, 0.20, 0.159),
            (sheet,),
            parent=root,
        ),
        place(scene, "Exhaust.003", joined([*muffler, can]), (sheet,), parent=root),
    ]


def _add_wheels(scene: Scene) -> dict[str, Object]:
    """Tyres with their rims, each one object with a mass: they strike what they roll on."""
    half = TREAD / 2
    rubber, alloy = surface("Rubber_Tire", "#1a1a1c", 0.9), surface("Alu_Rim", "#c9cdd1", 0.3, 1.0)
    tyre = lathe(
        (
            (0.085, -half),
            (0.125, -half),
            (WHEEL, -0.042),
            (WHEEL, 0.042),
            (0.125, half),
            (0.085, half),
        ),
        48,
    )
    hub = cylinder(0.03, TREAD, 20, 0.004).painted(1)
    rim = [
        box((0.15, 0.03, TREAD), 0.004).turned(k * math.pi / 5, "Z").painted(1) for k in range(5)
    ]
    shape = joined([tyre, hub, *rim])
    wheels = {}
    for end in AXLES:
        for side in TRACK:
            wheel = place(scene, f"Wheel_{end}{side}.001", shape, (rubber, alloy))
            wheel.rotation_mode = "ZYX"  # spins about its own z axis, which lies along x
            wheels[end + side] = give_mass(scene, wheel, MASS, "CYLINDER")
    return wheels


def _add_helmet(scene: Scene, root: Object) -> Object:
    """A helmet on the driver's head: nothing haptic."""
    head = trunk_frame(_posture())(0.0, 0.015, 0.775)
    turn = Matrix.Rotation(-LEAN * 0.5, 4, "X")
    shell = superellipsoid((0.225, 0.27, 0.25), 0.9)
    visor = superellipsoid((0.20, 0.14, 0.09), 0.7).moved(0.0, -0.075, -0.01).painted(1)
    materials = (surface("Helmet_White", "#f0efe9", 0.2), surface("Visor_Dark", "#15181c", 0.1))
    shape = (shell + visor).transformed(Matrix.Translation(head) @ turn)
    return place(scene, "Helmet", shape, materials, parent=root)


def _height(side: str, y: float, setts: list[Point]) -> float:
    """How high the middle of a wheel is above its place on flat ground."""
    x, half = TRACK[side], SETT[0] / 2 - CHAMFER
    edges = [(sy, half, z) for sx, sy, z in setts if abs(sx - x) < half + TREAD / 2]
    if side == "R":
        edges += [(sy, STONE_TOP / 2, STONE_HEIGHT - SUNK) for sy in _stone_places()]
    is_bedded = FIRST_SETT - (ROWS - 0.5) * SETT_STEP < y < FIRST_SETT + SETT_STEP / 2
    found = [-0.006 if is_bedded else 0.0]
    for place_y, reach, top in edges:
        beside = max(abs(y - place_y) - reach, 0.0)
        if beside < WHEEL:
            found.append(top - WHEEL + math.sqrt(WHEEL**2 - beside**2))
    return max(found)


def _drive(root: Object, wheels: dict[str, Object], camera: Object, setts: list[Point]) -> None:
    """Each wheel rolls over what lies there; the frame follows the four, smoothed by its tyres."""
    ways = {frame: START - STEP * frame for frame in range(1, FRAMES + 1)}
    heights = {
        name: {frame: _height(name[1], y + AXLES[name[0]], setts) for frame, y in ways.items()}
        for name in wheels
    }
    for name, wheel in wheels.items():
        x, y = TRACK[name[1]], AXLES[name[0]]
        animate(
            wheel,
            "location",
            {frame: (x, y + way, WHEEL + heights[name][frame]) for frame, way in ways.items()},
        )
        animate(
            wheel,
            "rotation_euler",
            {frame: (0.0, math.pi / 2, STEP * frame / WHEEL) for frame in ways},
        )
    locations, turns = {}, {}
    for frame, way in ways.items():
        near = [k for k in (frame - 1, frame, frame + 1) if k in ways]
        mean = {name: sum(own[k] for k in near) / len(near) for name, own in heights.items()}
        front, rear = ((mean[f"{end}L"] + mean[f"{end}R"]) / 2 for end in "FR")
        left, right = ((mean[f"F{side}"] + mean[f"R{side}"]) / 2 for side in "LR")
        slope = (rear - front) / (AXLES["R"] - AXLES["F"])
        locations[frame] = (0.0, way, rear - slope * AXLES["R"])
        turns[frame] = (slope, (right - left) / (TRACK["L"] - TRACK["R"]), 0.0)
    animate(root, "location", locations)
    animate(root, "rotation_euler", turns)
    at = camera.location.copy()
    animate(camera, "location", {frame: (at.x, at.y + way, at.z) for frame, way in ways.items()})


def _add_surroundings(scene: Scene) -> Object:
    """Meadow, tyre stacks and cones: nothing haptic."""
    meadow = box((120.0, 120.0, 0.1)).moved(z=-0.05 - 0.02)
    place(
        scene,
        "Meadow",
        meadow,
        (surface("Meadow", "#6f8f4c", 0.95, mottle=0.25, mottle_scale=0.4),),
    )
    rings = joined(torus(0.22, 0.085, 20, 8).moved(z=0.08 + 0.16 * level) for level in range(3))
    black, white = (
        surface("Barrier_Black", "#202124", 0.9),
        surface("Barrier_White", "#dedcd4", 0.7),
    )
    for number in range(22):
        place(
            scene,
            f"Tyre_Stack_{number + 1:02}",
            rings.painted(0),
            (white if number % 3 == 0 else black,),
            (2.1, 2.2 - 0.62 * number, 0.0),
        )
    cone = lathe(((0.16, 0.0), (0.16, 0.02), (0.10, 0.03), (0.02, 0.42)), 16)
    for number, y in enumerate((-0.9, -4.9, -8.1), 1):
        place(
            scene,
            f"Cone_{number}",
            cone,
            (surface(f"Cone_{number}", "#e8541e", 0.5),),
            (-1.25, y, 0.0),
        )
    add_world(scene, "#a9cdf0", 0.8)
    add_sun(scene, "Sun", (0.55, -0.35, -0.8), 3.2, "#fff0d8")
    return add_camera(scene, (-2.35, -2.0, 1.25), (0.0, -0.22, 0.36), 36.0)
