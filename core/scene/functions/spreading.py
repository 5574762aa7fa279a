"""Geometric spreading of waves: through a volume or over a surface up to a first distance, over a
surface up to a second one, and no further."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray, IntArray


class Law(NamedTuple):
    """The gain ``(1 + min(d, extent) / reference)^-exponent``, and from the distance ``extent`` to
    ``over`` times ``(1 + (d - extent) / width)^-1/2``.

    Lengths in metres. Where ``over`` exceeds the extent, the exponent is 1 and the width is at
    least ``reference + extent``: so the cost ``-log(gain)`` is 0 at distance 0, concave and
    non-decreasing, a metric.
    """

    exponent: float
    reference: float
    extent: float
    width: float
    over: float

    def cost(self, distance: float) -> float:
        """The cost over one distance."""
        cost = self.exponent * math.log1p(min(distance, self.extent) / self.reference)
        return (
            cost + 0.5 * math.log1p((min(distance, self.over) - self.extent) / self.width)
            if distance > self.extent
            else cost
        )


NO_SPREADING = Law(0.0, 1.0, math.inf, 1.0, math.inf)


class Spreading:
    """The laws of several objects or nodes as arrays."""

    def __init__(self, near: FloatArray, far: FloatArray | None) -> None:
        self._near, self._far = near, far

    @classmethod
    def of(cls, laws: Sequence[Law]) -> Spreading | None:
        """The laws as arrays; None if waves spread in none of the objects."""
        if not any(law.exponent for law in laws):
            return None
        near, far = np.split(np.array(laws).T, [3])
        return cls(near, np.stack([near[2], *far]) if (far[1] > near[2]).any() else None)

    def at(self, index: IntArray | int) -> Spreading:
        """The laws of some objects or nodes, by number."""
        return Spreading(self._near[:, index], None if self._far is None else self._far[:, index])

    def cost(self, distance: FloatArray) -> FloatArray:
        """The cost over distances, one for each law."""
        exponent, reference, extent = self._near
        cost = exponent * np.log1p(np.minimum(distance, extent) / reference)
        if self._far is not None:
            begin, width, over = self._far
            cost += 0.5 * np.log1p(np.maximum(np.minimum(distance, over) - begin, 0.0) / width)
        return np.asarray(cost)
