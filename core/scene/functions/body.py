"""What of a body decides its driving-point impedance."""

from __future__ import annotations

import math
from typing import NamedTuple


class Body(NamedTuple):
    """A body of ``density`` [kg/m^3] with waves of ``speed`` [m/s] and the sizes ``length``,
    ``width`` and ``thickness`` [m], whose product is its volume; it bends in its thickness.

    ``radius``: of the area of a half-space that is driven [m], else 0. ``resonance``: up to which a
    limb moves as a whole [Hz], else infinite. ``stiffness``: of a spring [N/m], else infinite, with
    its ``loss_factor``.
    """

    density: float = 1.0
    speed: float = 1.0
    radius: float = 0.0
    resonance: float = math.inf
    stiffness: float = math.inf
    loss_factor: float = 0.0
    length: float = 1.0
    width: float = 1.0
    thickness: float = 1.0
