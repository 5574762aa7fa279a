"""Pairs of bodies whose widened bounding boxes overlap: they stay the same for several frames."""

from __future__ import annotations

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, carried, connected
from .body_table import BodyTable
from .broad_phase import overlapping_pairs
from .motion import MotionHistory

_WIDENING = 0.05
"""Metres by which bounds are widened, so that they hold for several frames."""


class NearPairs:
    """The near pairs of n bodies.

    Attributes:
        key: (p,) by `BodyTable.keys`, ascending.
        larger, smaller: (p,) numbers of the bodies, by their size.
    """

    def __init__(self, count: int) -> None:
        self.key = self.larger = self.smaller = np.zeros(0, dtype=np.int64)
        self._wide = np.full((2, 3, count), -np.inf)  # as `BodyPoses.extents`
        self._heap = np.arange(count)  # of each body: connected component of the pairs

    def widen(
        self,
        table: BodyTable,
        history: MotionHistory,
        extents: FloatArray,
        moved: IntArray,
    ) -> None:
        """Find the pairs again if the wide bounds of bodies that have ``moved`` do not contain
        those with these ``extents`` (2, 3, n) any more. Bounds are wider where bodies drift."""
        inside = extents.take(moved, axis=2) <= self._wide.take(moved, axis=2)
        rows = moved[~inside.all(axis=(0, 1))]
        if len(rows) == 0:
            return
        drift = history.drift(rows)
        ahead = 2 * np.maximum([-drift, drift], 0.0)
        self._wide[..., rows] = extents[..., rows] + _WIDENING + ahead
        escaped = np.zeros(len(table), dtype=np.bool_)
        escaped[rows] = True
        key = overlapping_pairs(-self._wide[0], self._wide[1], escaped)
        if len(rows) < len(table):
            stays = ~(escaped[self.larger] | escaped[self.smaller])
            key = np.concatenate([self.key[stays], key])
            key.sort()
        if not np.array_equal(key, self.key):
            self._take(table, key)

    def _take(self, table: BodyTable, key: IntArray) -> None:
        self.key = key
        self._heap = connected(table.numbers(key), len(table))
        self.larger, self.smaller = table.by_size(key)

    def met(self, extents: FloatArray, rows: IntArray | slice = slice(None)) -> BoolArray:
        """Which pairs (p,), or which of some ``rows`` (k,) of them, have overlapping bounds, of
        bodies with these ``extents`` (2, 3, n)."""
        low, high = -extents[0], extents[1]
        larger, smaller = self.larger[rows], self.smaller[rows]
        met = low.take(larger, axis=1) <= high.take(smaller, axis=1)
        met &= low.take(smaller, axis=1) <= high.take(larger, axis=1)
        return np.asarray(met.all(axis=0))

    def in_heaps_of(self, bodies: BoolArray) -> BoolArray:
        """Which bodies (n,) are in the same heap as one of the ``bodies`` (n,): chains of pairs
        join them."""
        reached = np.zeros(len(bodies), dtype=np.bool_)
        reached[self._heap[bodies]] = True
        return reached[self._heap]

    def forget(self, table: BodyTable, bodies: BoolArray) -> None:
        """Count the next bounds of ``bodies`` (n,), which have changed, as their first ones."""
        self._wide[..., bodies] = -np.inf
        self.larger, self.smaller = table.by_size(self.key)

    def renumber(self, table: BodyTable, before: IntArray, key: IntArray) -> None:
        """Follow a new order of the bodies of ``table``, as `BodyPoses.renumber`; ``key``: what
        remains of the pairs."""
        self._wide = carried(self._wide, before, -np.inf)
        self._take(table, key)
