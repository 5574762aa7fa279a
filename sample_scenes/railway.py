"""Track: rails on sleepers, and wheelsets that stand on the rails."""

from __future__ import annotations

import math

from bpy.types import Material, Object, Scene

from .geometry import SUNK, Geometry, Point, box, cylinder, joined, prism, rod
from .materials import HARDWOOD, STEEL
from .staging import make_static, place

SLEEPER = (0.24, 2.3, 0.13)
RAIL_HEIGHT, RAIL_FOOT = 0.14, 0.12
GAUGE, MINE_GAUGE = 1.435, 0.9
RAIL_HEAD = 0.07
RAIL_TOP = SLEEPER[2] + RAIL_HEIGHT - 2 * SUNK


def add_sleepers(scene: Scene, name: str, wood: Material, xs: list[float]) -> list[Object]:
    """Sleepers across x on the ground at z = 0."""
    shape = box(SLEEPER, 0.012).moved(z=SLEEPER[2] / 2)
    sleepers = [
        place(scene, f"{name} {number}", shape, (wood,), (x, 0.0, -SUNK))
        for number, x in enumerate(xs, 1)
    ]
    return [make_static(scene, sleeper, HARDWOOD, "BOX") for sleeper in sleepers]


def add_rails(
    scene: Scene,
    name: str,
    steel: Material,
    low: float,
    high: float,
    gauge: float = GAUGE,
    height: float = SLEEPER[2] - 2 * SUNK,
) -> list[Object]:
    """A pair of rails along x, their feet at ``height``, as on sleepers: ``name.L`` on the side of
    +Y."""
    rails = []
    for side, letter in ((1.0, "L"), (-1.0, "R")):
        rail = place(
            scene,
            f"{name}.{letter}",
            rail_shape(high - low),
            (steel,),
            (low, side * (gauge + RAIL_HEAD) / 2, height),
        )
        rails.append(make_static(scene, rail, STEEL, "BOX"))
    return rails


def rail_shape(length: float) -> Geometry:
    """A rail from x = 0 to ``length``, its foot on z = 0."""
    foot, web, head = RAIL_FOOT / 2, 0.009, 0.034
    half = (
        (foot, 0.0),
        (foot, 0.012),
        (web, 0.026),
        (web, 0.095),
        (head, 0.106),
        (head, RAIL_HEIGHT - 0.006),
        (head - 0.008, RAIL_HEIGHT),
    )
    outline = half + tuple((-x, z) for x, z in reversed(half))
    return prism(outline, length).turned(math.pi / 2, "X").turned(math.pi / 2, "Z")


def wheelset(radius: float, gauge: float = GAUGE) -> Geometry:
    """Two wheels on an axle along y about the origin."""
    rail_y = (gauge + RAIL_HEAD) / 2
    wheel = cylinder(radius, 0.11, 32, 0.012).turned(math.pi / 2, "X")
    hub = cylinder(0.3 * radius, 0.16, 20, 0.01).turned(math.pi / 2, "X")
    sides = [
        part.moved(y=side * rail_y) for side in (-1.0, 1.0) for part in (wheel, hub.painted(1))
    ]
    return joined([*sides, rod((0.0, -rail_y, 0.0), (0.0, rail_y, 0.0), 0.3 * radius).painted(1)])


def on_rails(radius: float) -> Point:
    """Where the middle of a wheelset of that radius is above the middle of the track."""
    return (0.0, 0.0, RAIL_TOP + radius - SUNK)
