"""Things to sit on."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from bpy.types import Material, Object, Scene
from mathutils import Matrix, Vector

from .geometry import SUNK, Geometry, Point, box, joined
from .materials import STEEL, WOOD
from .staging import make_static, place

SEAT_THICKNESS = 0.045
BACK_THICKNESS = 0.035
BACK_HEIGHT = 0.58


@dataclass(frozen=True, slots=True)
class Seat:
    """A piece of furniture to sit on: its haptic parts by name."""

    parts: Mapping[str, Object]


def add_bench(
    scene: Scene, location: Point, wood: Material, metal: Material, *, width: float = 1.7, depth: float = 0.44, height: float = 0.45,
    lean: float = math.radians(10)
) -> Seat:
    """A park bench: a slatted seat on four separate feet, and a slatted back that leans back by ``lean``.

    It faces -Y. ``location`` is on the ground below the line where the front of the back meets the top of the seat.
    """
    origin = Vector(location) - Vector((0.0, 0.0, SUNK))
    behind = 0.06  # the seat reaches under the back
    seat = joined(_slats(width, depth + behind, SEAT_THICKNESS, 4).values())
    middle = origin + Vector((0.0, (behind - depth) / 2, height + SUNK - SEAT_THICKNESS / 2))
    parts = {"Bench Seat": make_static(scene, place(scene, "Bench Seat", seat, (wood, metal), middle), WOOD, "BOX")}
    for x, across in ((0.5 * width - 0.14, "L"), (0.14 - 0.5 * width, "R")):
        for y, along in ((0.09 - depth, "Front"), (behind - 0.07, "Back")):
            name = f"Bench Foot {along}.{across}"
            foot = _foot(height - SEAT_THICKNESS + 2 * SUNK)
            parts[name] = make_static(scene, place(scene, name, foot, (metal,), origin + Vector((x, y, 0.0))), STEEL)
    back = _back(width, BACK_HEIGHT)
    turn = Matrix.Rotation(-lean, 4, "X")
    # The lower edge of the tilted board stands on the seat.
    rise = BACK_THICKNESS * math.sin(lean)
    place_of_back = origin + Vector((0.0, 0.0, height + rise)) + turn @ Vector((0.0, BACK_THICKNESS / 2, BACK_HEIGHT / 2))
    board = place(scene, "Bench Back", back, (wood, metal), place_of_back, (-lean, 0.0, 0.0))
    parts["Bench Back"] = make_static(scene, board, WOOD, "BOX")
    return Seat(parts)


def _slats(width: float, depth: float, thickness: float, count: int) -> dict[str, Geometry]:
    """Boards along x with gaps, on two metal bars below; together they fill the box width x depth x thickness about the origin."""
    bar, gap = 0.012, 0.018
    board = (depth - gap * (count - 1)) / count
    slats = [
        box((width, board, thickness - bar), 0.006).moved(0.0, (k + 0.5) * board + k * gap - depth / 2, bar / 2) for k in range(count)
    ]
    bars = [box((0.05, depth, bar)).moved(x, 0.0, (bar - thickness) / 2).painted(1) for x in (0.14 - width / 2, width / 2 - 0.14)]
    return {"boards": joined(slats), "bars": joined(bars)}


def _back(width: float, height: float) -> Geometry:
    """Three boards along x on two posts; it fills the box width x BACK_THICKNESS x height about the origin."""
    post = 0.012
    board = 0.11
    boards = [box((width, BACK_THICKNESS - post, board), 0.006).moved(0.0, -post / 2, height / 2 - down) for down in (0.055, 0.20, 0.345)]
    posts = [box((0.05, post, height)).moved(x, (BACK_THICKNESS - post) / 2, 0.0).painted(1) for x in (0.14 - width / 2, width / 2 - 0.14)]
    return joined(boards + posts)


def _foot(height: float) -> Geometry:
    """A metal foot with a plate on the ground and one below the seat."""
    plate = 0.012
    return joined(
        (
            box((0.09, 0.09, plate), 0.003).moved(z=plate / 2),
            box((0.045, 0.045, height - 2 * plate), 0.006).moved(z=height / 2),
            box((0.07, 0.07, plate), 0.003).moved(z=height - plate / 2),
        )
    )
