"""Picture of the body from `body_map.json`: the positions of the 25 parts on a front view and a
back view.

A figure is 2 units high, its middle at x = 0, its feet at y = 0; the wearer's left is at the right
of the figure seen from the front.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Literal

from ..forms import Form
from ..frozen import frozen

HEIGHT, HALF_WIDTH = 2.0, 0.62

View = Literal["front", "back"]


@frozen
class Limb:
    """A stroke with round ends from ``start`` to ``end``, ``width`` wide, or a disc where both are
    equal. ``part``: the body part."""

    part: str
    start: tuple[float, float]
    end: tuple[float, float]
    width: float


@frozen
class Spot:
    """An actuator of a body part: coordinates from the wearer's left and from the top, 0 to 1, and
    its share of the amplitude."""

    part: str
    across: float
    down: float
    amplitude: float


_TABLE = json.loads(Path(__file__).with_name("body_map.json").read_text("utf-8"))
"""By view: the shapes on the midline and on the wearer's left side, as seen from behind, where that
side is x < 0."""


def _limb(row: Form, side: str, mirror: float) -> Limb:
    start, end = ((mirror * x, y) for x, y in (row["start"], row["end"]))
    return Limb(row["part"] + side, start, end, row["width"])


def figure(view: View) -> tuple[Limb, ...]:
    """All parts that are visible from the front or from behind."""
    turn = -1.0 if view == "front" else 1.0
    midline = [_limb(row, "", 1.0) for row in _TABLE[view]["midline"]]
    return (
        *midline,
        *(
            _limb(row, side, mirror)
            for row in _TABLE[view]["left"]
            for side, mirror in ((".L", turn), (".R", -turn))
        ),
    )
