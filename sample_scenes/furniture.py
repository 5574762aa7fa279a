"""Benches, tables, chairs: each a set of separate haptic parts that touch, returned by name."""

from __future__ import annotations

import math

from bpy.types import Material, Object, Scene
from mathutils import Matrix, Vector

from .geometry import SUNK, Geometry, Point, box, joined, lathe, rod
from .materials import FABRIC, HARDWOOD, STEEL
from .staging import make_static, place, place_empty

SEAT_THICKNESS = 0.045
BACK_THICKNESS = 0.035
BACK_HEIGHT = 0.58


def add_bench(
    scene: Scene,
    location: Point,
    wood: Material,
    metal: Material,
    *,
    width: float = 1.7,
    depth: float = 0.44,
    height: float = 0.45,
    lean: float = math.radians(10),
) -> dict[str, Object]:
    """A park bench: a slatted seat on four separate feet, and a slatted back that leans back by
    ``lean``.

    It faces -Y. ``location`` is on the ground below the line where the front of the back meets the
    top of the seat.
    """
    origin = Vector(location) - Vector((0.0, 0.0, SUNK))
    behind = 0.06  # the seat reaches under the back
    seat = joined(_slats(width, depth + behind, SEAT_THICKNESS, 4).values())
    middle = origin + Vector((0.0, (behind - depth) / 2, height + SUNK - SEAT_THICKNESS / 2))
    parts = {
        "Bench Seat": make_static(
            scene, place(scene, "Bench Seat", seat, (wood, metal), middle), HARDWOOD, "BOX"
        )
    }
    foot = _foot(height - SEAT_THICKNESS + 2 * SUNK)
    for (x, y), corner in zip(
        _corners(width / 2 - 0.14, 0.09 - depth, behind - 0.07), _CORNERS, strict=True
    ):
        name = f"Bench Foot {corner}"
        parts[name] = make_static(
            scene, place(scene, name, foot, (metal,), origin + Vector((x, y, 0.0))), STEEL
        )
    back = _back(width, BACK_HEIGHT)
    turn = Matrix.Rotation(-lean, 4, "X")
    # The lower edge of the tilted board stands on the seat.
    rise = BACK_THICKNESS * math.sin(lean)
    place_of_back = (
        origin
        + Vector((0.0, 0.0, height + rise))
        + turn @ Vector((0.0, BACK_THICKNESS / 2, BACK_HEIGHT / 2))
    )
    board = place(scene, "Bench Back", back, (wood, metal), place_of_back, (-lean, 0.0, 0.0))
    parts["Bench Back"] = make_static(scene, board, HARDWOOD, "BOX")
    return parts


def add_table(
    scene: Scene,
    name: str,
    location: Point,
    top: Material,
    legs: Material,
    *,
    size: tuple[float, float],
    height: float,
) -> dict[str, Object]:
    """A table: a top of ``size`` (x, y), its upper side at ``height``, on four separate legs.
    ``location`` is on the ground below it."""
    origin = Vector(location)
    width, depth = size
    thickness = 0.05
    board = box((width, depth, thickness), 0.008)
    parts = {
        f"{name} Top": place(
            scene, f"{name} Top", board, (top,), origin + Vector((0.0, 0.0, height - thickness / 2))
        )
    }
    make_static(scene, parts[f"{name} Top"], HARDWOOD, "BOX")
    shape = box((0.07, 0.07, height - thickness + 2 * SUNK), 0.008).moved(
        z=(height - thickness) / 2
    )
    for (x, y), corner in zip(
        _corners(width / 2 - 0.06, 0.06 - depth / 2, depth / 2 - 0.06), _CORNERS, strict=True
    ):
        leg = f"{name} Leg {corner}"
        parts[leg] = make_static(
            scene, place(scene, leg, shape, (legs,), origin + Vector((x, y, 0.0))), HARDWOOD, "BOX"
        )
    return parts


def add_chair(
    scene: Scene, location: Point, wood: Material, *, heading: float, height: float, lean: float
) -> dict[str, Object]:
    """A kitchen chair: a seat on four separate legs, and a back that leans back by ``lean``.

    It faces -Y, turned by ``heading`` about z. ``location`` is on the ground below the line where
    the front of the back meets the seat.
    """
    root = place_empty(scene, "Chair", location, size=0.2, heading=heading)
    width, depth, behind, thickness = 0.44, 0.42, 0.05, 0.04
    seat = box((width, depth + behind, thickness), 0.012).moved(
        0.0, (behind - depth) / 2, height - thickness / 2
    )
    parts = {
        "Chair Seat": make_static(
            scene, place(scene, "Chair Seat", seat, (wood,), parent=root), HARDWOOD, "BOX"
        )
    }
    leg = lathe(((0.016, -SUNK), (0.022, height - thickness + SUNK)), 16)
    for (x, y), name in zip(
        _corners(width / 2 - 0.035, 0.045 - depth, behind - 0.035), _CORNERS, strict=True
    ):
        parts[f"Chair Leg {name}"] = make_static(
            scene,
            place(scene, f"Chair Leg {name}", leg, (wood,), (x, y, 0.0), parent=root),
            HARDWOOD,
        )
    board = 0.025
    posts = [rod((x, board / 2, 0.0), (x, board / 2, 0.50), board / 2, 16) for x in (-0.19, 0.19)]
    slats = [box((0.40, 0.016, 0.09), 0.006).moved(0.0, board / 2, z) for z in (0.45, 0.30, 0.15)]
    standing_on_seat = (0.0, 0.0, height + board * math.sin(lean) - SUNK)
    back = place(
        scene,
        "Chair Back",
        joined(posts + slats),
        (wood,),
        standing_on_seat,
        (-lean, 0.0, 0.0),
        root,
    )
    parts["Chair Back"] = make_static(scene, back, HARDWOOD)
    return parts


def add_armchair(
    scene: Scene,
    location: Point,
    cloth: Material,
    wood: Material,
    *,
    heading: float,
    height: float,
    lean: float,
) -> dict[str, Object]:
    """An upholstered chair: a seat on four separate feet, a back that leans back by ``lean``, two
    arms at the seat's sides.

    Placed like `add_chair`.
    """
    root = place_empty(scene, "Armchair", location, size=0.2, heading=heading)
    width, depth, behind, foot, arm = 0.60, 0.50, 0.20, 0.11, 0.11
    seat = box((width, depth + behind, height - foot), 0.03).moved(
        0.0, (behind - depth) / 2, (height + foot) / 2
    )
    parts = {
        "Armchair Seat": make_static(
            scene, place(scene, "Armchair Seat", seat, (cloth,), parent=root), FABRIC, "BOX"
        )
    }
    leg = lathe(((0.018, -SUNK), (0.026, foot + SUNK)), 16)
    for (x, y), name in zip(
        _corners(width / 2 - 0.05, 0.06 - depth, behind - 0.06), _CORNERS, strict=True
    ):
        foot_name = f"Armchair Foot {name}"
        parts[foot_name] = make_static(
            scene, place(scene, foot_name, leg, (wood,), (x, y, 0.0), parent=root), HARDWOOD
        )
    for x, side in ((1.0, "L"), (-1.0, "R")):
        shape = box((arm, depth + behind, 0.48), 0.03).moved(
            x * (width + arm - 2 * SUNK) / 2, (behind - depth) / 2, foot + 0.02 + 0.24
        )
        parts[f"Armchair Arm.{side}"] = make_static(
            scene, place(scene, f"Armchair Arm.{side}", shape, (cloth,), parent=root), FABRIC, "BOX"
        )
    thickness = 0.13
    back = box((width - 4 * SUNK, thickness, 0.72), 0.03).moved(0.0, thickness / 2, 0.36)
    standing_on_seat = (0.0, 0.0, height + thickness * math.sin(lean) - SUNK)
    board = place(scene, "Armchair Back", back, (cloth,), standing_on_seat, (-lean, 0.0, 0.0), root)
    parts["Armchair Back"] = make_static(scene, board, FABRIC, "BOX")
    return parts


_CORNERS = ("Front.L", "Back.L", "Front.R", "Back.R")


def _corners(x: float, front: float, back: float) -> tuple[tuple[float, float], ...]:
    """Where four feet stand, in the order of their names."""
    return ((x, front), (x, back), (-x, front), (-x, back))


def _slats(width: float, depth: float, thickness: float, count: int) -> dict[str, Geometry]:
    """Boards along x with gaps, on two metal bars below; together they fill the box width x depth x
    thickness about the origin."""
    bar, gap = 0.012, 0.018
    board = (depth - gap * (count - 1)) / count
    slats = [
        box((width, board, thickness - bar), 0.006).moved(
            0.0, (k + 0.5) * board + k * gap - depth / 2, bar / 2
        )
        for k in range(count)
    ]
    bars = [
        box((0.05, depth, bar)).moved(x, 0.0, (bar - thickness) / 2).painted(1)
        for x in (0.14 - width / 2, width / 2 - 0.14)
    ]
    return {"boards": joined(slats), "bars": joined(bars)}


def _back(width: float, height: float) -> Geometry:
    """Three boards along x on two posts; it fills the box width x BACK_THICKNESS x height about the
    origin."""
    post = 0.012
    board = 0.11
    boards = [
        box((width, BACK_THICKNESS - post, board), 0.006).moved(0.0, -post / 2, height / 2 - down)
        for down in (0.055, 0.20, 0.345)
    ]
    posts = [
        box((0.05, post, height)).moved(x, (BACK_THICKNESS - post) / 2, 0.0).painted(1)
        for x in (0.14 - width / 2, width / 2 - 0.14)
    ]
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
