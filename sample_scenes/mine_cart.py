"""Mine carts: boxes of boards on two wheelsets, each part a haptic object."""

from __future__ import annotations

import math
from collections.abc import Mapping

from bpy.types import Object, Scene

from ..core.frozen import frozen
from .animation import animate
from .geometry import SUNK, Geometry, box, joined, rod
from .materials import HARDWOOD, STEEL, surface
from .mine import TOP_OF_RAIL
from .railway import MINE_GAUGE, RAIL_HEAD
from .railway import wheelset as wheelset_shape
from .staging import make_moving, place, place_empty

WHEEL = 0.17
LENGTH, WIDTH, RIM = 1.75, 1.24, 0.50  # outside; the rim is above the floor
BOARD = 0.05
FLOOR = TOP_OF_RAIL + 2 * WHEEL - 2 * SUNK + BOARD  # upper side of the cart's floor
SEAT_HEIGHT = 0.42  # above the floor
LEAN = math.radians(10)
BACK_X = -0.52  # where seat and backrest meet

# Kilograms. Wheels roll from one rail onto the next all the time; so light, they hit none with 5 J,
# nor do boards hit walls so.
WHEELSET_MASS, BOARD_MASS = 0.5, 2.0


@frozen
class Cart:
    """What carries the cart, its haptic parts by name, its haptic wheelsets, and the wheels that
    are seen to roll."""

    root: Object
    parts: Mapping[str, Object]
    wheelsets: tuple[Object, ...]
    wheels: tuple[Object, ...]


def add_cart(scene: Scene, name: str, colour: str, *, seat: bool) -> Cart:
    """A cart at the origin that faces +X; its root is to be animated. With ``seat``, a seat and a
    backrest."""
    root = place_empty(scene, name, size=0.4)
    wood, iron = (
        surface(f"{name} Boards", colour, 0.7, mottle=0.35, mottle_scale=5.0),
        surface(f"{name} Iron", "#3a3937", 0.45, 0.8),
    )
    inside = FLOOR - BOARD / 2
    shapes: dict[str, Geometry] = {"Floor": box((LENGTH, WIDTH, BOARD), 0.005).moved(z=inside)}
    for side, letter in ((1.0, "L"), (-1.0, "R")):
        shapes[f"Side.{letter}"] = _wall(LENGTH).moved(
            0.0, side * (WIDTH - BOARD) / 2, FLOOR - SUNK
        )
    for side, end in ((1.0, "Front"), (-1.0, "Back")):
        across = _wall(WIDTH - 2 * BOARD + 2 * SUNK).turned(math.pi / 2, "Z")
        shapes[end] = across.moved(side * (LENGTH - BOARD) / 2, 0.0, FLOOR - SUNK)
    if seat:
        bench = box((0.56, WIDTH - 2 * BOARD - 0.06, SEAT_HEIGHT + SUNK), 0.03)
        shapes["Seat"] = bench.moved(BACK_X + 0.20, 0.0, FLOOR + (SEAT_HEIGHT - SUNK) / 2)
    parts = {
        part: place(scene, f"{name} {part}", shape, (wood, iron), parent=root)
        for part, shape in shapes.items()
    }
    if seat:
        thickness = 0.06
        board = box((thickness, 0.62, 0.62), 0.02).moved(-thickness / 2, 0.0, 0.31)
        on_seat = (BACK_X, 0.0, FLOOR + SEAT_HEIGHT + thickness * math.sin(LEAN) - SUNK)
        parts["Backrest"] = place(
            scene, f"{name} Backrest", board, (wood, iron), on_seat, (0.0, -LEAN, 0.0), root
        )
    for part in parts.values():
        make_moving(scene, part, HARDWOOD, BOARD_MASS, "BOX")
    wheelsets = tuple(
        _wheelset(scene, f"{name} Wheelset {number}", root, x)
        for number, x in enumerate((-0.52, 0.52), 1)
    )
    wheels = tuple(
        _wheels(scene, f"{name} Wheels {number}", wheelset)
        for number, wheelset in enumerate(wheelsets, 1)
    )
    x, y, rim = LENGTH / 2, WIDTH / 2, FLOOR + RIM
    trim = [rod((-x, side * y, rim), (x, side * y, rim), 0.02, 8) for side in (-1, 1)]
    trim += [rod((side * x, -y, rim), (side * x, y, rim), 0.02, 8) for side in (-1, 1)]
    place(scene, f"{name} Trim", joined(trim), (iron,), parent=root)
    return Cart(root, parts, wheelsets, wheels)


def _wall(length: float) -> Geometry:
    """A wall of boards along x with iron bands on z = 0."""
    boards = [
        box((length, BOARD - 0.012, RIM / 3 - 0.008), 0.005).moved(0.0, 0.0, (k + 0.5) * RIM / 3)
        for k in range(3)
    ]
    bands = [
        box((0.06, BOARD, RIM)).moved(x, 0.0, RIM / 2).painted(1)
        for x in (-length / 2 + 0.12, length / 2 - 0.12)
    ]
    return joined([*boards, *bands])


def _wheelset(scene: Scene, name: str, root: Object, x: float) -> Object:
    """A box about a wheelset. It does not roll: so only what it rolls on has to be looked at in
    every frame."""
    shape = box((2 * WHEEL, MINE_GAUGE + 2 * RAIL_HEAD, 2 * WHEEL))
    iron = surface(f"{name} Iron", "#3a3937", 0.45, 0.8)
    wheelset = place(scene, name, shape, (iron,), (x, 0.0, TOP_OF_RAIL + WHEEL - SUNK), parent=root)
    wheelset.display_type = "WIRE"
    wheelset.hide_render = True
    return make_moving(scene, wheelset, STEEL, WHEELSET_MASS, "BOX")


def _wheels(scene: Scene, name: str, wheelset: Object) -> Object:
    """What is seen of a wheelset: nothing haptic."""
    iron, dark = (
        surface(f"{name} Tread", "#8b8783", 0.35, 0.9),
        surface(f"{name} Hub", "#2f2d2b", 0.6, 0.5),
    )
    return place(scene, name, wheelset_shape(WHEEL, MINE_GAUGE), (iron, dark), parent=wheelset)


def roll(cart: Cart, distances: Mapping[float, float]) -> None:
    """Turn the wheels as far as the cart has gone, in metres by frame."""
    for wheels in cart.wheels:
        animate(
            wheels,
            "rotation_euler",
            {frame: (0.0, distance / WHEEL, 0.0) for frame, distance in distances.items()},
        )
