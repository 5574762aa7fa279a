"""Geometric spreading of waves: through a volume up to a first distance, over a surface up to a second one, and no further."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray, IntArray


class Spreading(NamedTuple):
    """The gain ``(1 + min(d, through) / radius)^-1 (1 + (min(d, over) - min(d, through)) / width)^-1/2``.

    Its cost ``-log(gain)`` is 0 at distance 0, concave and non-decreasing: a metric. Lengths [m], or arrays of them by object or node:

    ``radius`` from which a wave spreads through a volume, ``through`` the distance where that ends; ``width`` from which it spreads over a
    surface, ``over`` the distance where that ends, at least ``through``.
    """

    radius: FloatArray | float
    through: FloatArray | float
    width: FloatArray | float
    over: FloatArray | float

    def cost(self, distance: FloatArray) -> FloatArray:
        """The cost over distances, of which each has its own lengths if these are arrays."""
        volume = np.minimum(distance, self.through)
        cost = 0.5 * np.log1p((np.minimum(distance, self.over) - volume) / self.width)
        if np.any(self.through):
            cost += np.log1p(volume / self.radius)
        return np.asarray(cost)

    def of(self, index: IntArray | int) -> Spreading:
        """The lengths of some of the objects or nodes."""
        return Spreading(*(np.asarray(values)[index] for values in self))


def cost_over(law: Sequence[float], distance: float) -> float:
    """The cost of one `Spreading` over one distance."""
    radius, through, width, over = law
    volume = min(distance, through)
    return math.log1p(volume / radius) + 0.5 * math.log1p((min(distance, over) - volume) / width)


NO_SPREADING = Spreading(1.0, 0.0, 1.0, 0.0)
