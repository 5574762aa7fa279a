"""The body as a picture: the places of the 25 parts on a figure seen from the front and one from behind.

A figure is 2 units high, its middle at x = 0, its feet at y = 0; the wearer's left is at the right of the figure seen from the front.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

HEIGHT, HALF_WIDTH = 2.0, 0.62

View = Literal["front", "back"]


@dataclass(frozen=True, slots=True)
class Limb:
    """A stroke with round ends from ``start`` to ``end``, ``width`` wide, or a disc where both are equal. ``part``: the body part."""

    part: str
    start: tuple[float, float]
    end: tuple[float, float]
    width: float


@dataclass(frozen=True, slots=True)
class Spot:
    """An actuator of a body part: across from the wearer's left and down, 0 to 1, and its part of the amplitude."""

    part: str
    across: float
    down: float
    amplitude: float


# On the wearer's left side, seen from behind: x to the right is the wearer's right, so the left side has x < 0.
_MIDLINE = {
    "front": (
        ("head", (0.0, 1.80), (0.0, 1.84), 0.26),
        ("belly", (-0.07, 1.15), (0.07, 1.15), 0.22),
        ("hips", (-0.11, 0.98), (0.11, 0.98), 0.17),
    ),
    "back": (("head", (0.0, 1.80), (0.0, 1.84), 0.26), ("hips", (-0.11, 0.98), (0.11, 0.98), 0.17)),
}
_LIMBS = (
    ("upper_arm", (-0.30, 1.50), (-0.36, 1.22), 0.13),
    ("forearm", (-0.38, 1.12), (-0.44, 0.90), 0.11),
    ("hand", (-0.465, 0.80), (-0.475, 0.76), 0.12),
    ("index_finger", (-0.435, 0.665), (-0.44, 0.63), 0.045),
    ("upper_leg", (-0.12, 0.82), (-0.135, 0.56), 0.17),
    ("lower_leg", (-0.14, 0.43), (-0.145, 0.17), 0.13),
    ("foot", (-0.155, 0.055), (-0.185, 0.05), 0.09),
)
_SIDES = {
    "front": (("ear", (-0.165, 1.80), (-0.165, 1.80), 0.07), ("chest", (-0.105, 1.46), (-0.105, 1.36), 0.19), *_LIMBS),
    "back": (
        ("ear", (-0.165, 1.80), (-0.165, 1.80), 0.07),
        ("upper_back", (-0.105, 1.50), (-0.105, 1.43), 0.19),
        ("middle_back", (-0.095, 1.23), (-0.095, 1.17), 0.17),
        *_LIMBS,
    ),
}


def figure(view: View) -> tuple[Limb, ...]:
    """All parts that are seen from the front or from behind."""
    turn = -1.0 if view == "front" else 1.0
    limbs = [Limb(part, start, end, width) for part, start, end, width in _MIDLINE[view]]
    for part, start, end, width in _SIDES[view]:
        for side, mirror in (("L", turn), ("R", -turn)):
            limbs.append(Limb(f"{part}.{side}", (mirror * start[0], start[1]), (mirror * end[0], end[1]), width))
    return tuple(limbs)
