"""Joints, at whose pivots two objects stay together."""

from __future__ import annotations

import math
from dataclasses import MISSING, field

from ..declaration import Declared, check, numbers, part
from ..frozen import frozen


@frozen
class Joint(Declared):
    """A pivot that two objects have in common, as links of a robot have one. Where they touch at
    rest, they conduct there, whatever else of them touches, as long as it is the same point."""

    objects: tuple[str, str] = field(metadata=part(MISSING, "pair", "Names of both").metadata)
    positions: tuple[tuple[float, ...], ...] = field(
        metadata=part(MISSING, "positions", "Position of the pivot in the space of each").metadata
    )
    rotation: tuple[float, ...] = numbers(
        (1.0, 0.0, 0.0, 0.0),
        "",
        "Rotation of the second at rest in the space of the first: a quaternion (w, x, y, z)",
        4,
    )

    def __post_init__(self) -> None:
        check(self)
        if math.hypot(*self.rotation) < 1e-12:
            raise ValueError("rotation: a quaternion of length 0 is no rotation")
        object.__setattr__(self, "objects", tuple(self.objects))
        object.__setattr__(self, "positions", tuple(map(tuple, self.positions)))
        object.__setattr__(self, "rotation", tuple(self.rotation))
