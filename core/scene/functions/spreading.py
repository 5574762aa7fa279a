"""Geometric spreading of waves: through a volume or over a surface up to a first distance, over a
surface up to a second one, and no further. It begins at a point, or at a contact with the size of
its patch."""

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
    non-decreasing, a metric. In the equations of `Spreading` waves go on beyond ``over``; the width
    says how. Patches up to the size ``point`` count as points.
    """

    exponent: float
    reference: float
    extent: float
    width: float
    over: float
    point: float = math.inf


NO_SPREADING = Law(0.0, 1.0, math.inf, 1.0, math.inf)
_ONE = np.zeros(1, dtype=np.int64)


class Spreading:
    """Spreading laws of n objects as arrays. ``of`` (n,): the number of each object's law, by
    default that of a single object. ``point`` (n,): the largest size [m] of patches that count as
    points. ``has_fronts``: whether any may be larger."""

    def __init__(self, laws: Sequence[Law], of: IntArray = _ONE) -> None:
        self._laws = np.array([law[:5] for law in laws]).T.take(of, axis=1)
        self.point: FloatArray = np.array([law.point for law in laws]).take(of)
        self.has_fronts: bool = bool((self.point < math.inf).any())
        self._one_stage = bool((self._laws[4] <= self._laws[2]).all())

    @classmethod
    def of(cls, laws: Sequence[Law], of: IntArray = _ONE) -> Spreading | None:
        """The laws as arrays; None if waves spread in none of the objects."""
        return cls(laws, of) if any(law.exponent for law in laws) else None

    def fronts(self, index: IntArray, size: FloatArray) -> FloatArray:
        """Patches of ``size`` (m,) [m] in objects ``index`` (m,) as fronts of waves from a point:
        how far they have run [m], 0 for a point, and half the cost of that (2, m)."""
        run = np.maximum(size - self.point[index], 0.0)
        return np.stack([run, self._unbounded(index, run) / 2])

    def cost(
        self,
        index: IntArray | int,
        distance: FloatArray,
        ends: tuple[FloatArray, FloatArray] | None = None,
    ) -> FloatArray:
        """The cost over distances in objects ``index``, one for each distance or a single one.

        Between patches, a wave has run some way before: with R for the run of a front that is as
        large as a patch, it runs D = max(R_i, R_j, min(d + (R_i + R_j) / 2, over)), and its cost is
        S(D) - (S(R_i) + S(R_j)) / 2. S is concave, so that is a metric again.

        Args:
            index: of the objects.
            distance: [m].
            ends: `fronts` of the two ends; None if they are points.
        """
        if ends is not None:
            (one, half), (other, other_half) = ends
            run = np.minimum(distance + (one + other) / 2, self._laws[4].take(index))
            run = np.maximum(np.maximum(one, other), run)
            return np.asarray(np.maximum(self._unbounded(index, run) - (half + other_half), 0.0))
        if self._one_stage:
            exponent, reference, extent = self._laws[:3].take(index, axis=1)
            return np.asarray(exponent * np.log1p(np.minimum(distance, extent) / reference))
        return self._unbounded(index, np.minimum(distance, self._laws[4].take(index)))

    def detour(self, index: IntArray, one: FloatArray, other: FloatArray) -> FloatArray:
        """By how much the cost over two distances exceeds that over their sum, in objects ``index``
        (n,); it grows with each of the distances."""
        return self.cost(index, one) + self.cost(index, other) - self.cost(index, one + other)

    def _unbounded(self, index: IntArray | int, run: FloatArray) -> FloatArray:
        """The cost over a run [m] of waves that go on beyond ``over``."""
        exponent, reference, extent, width, _ = self._laws.take(index, axis=1)
        cost = exponent * np.log1p(np.minimum(run, extent) / reference)
        cost += 0.5 * np.log1p(np.maximum(run - extent, 0.0) / width)
        return np.asarray(cost)
