"""Patches that have been computed before: an edit or a jump asks for those of all bodies again, of
which most have not moved relative to each other."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ...arrays import FloatArray, IntArray
from ..shapes import Shape
from .body_patches import PairPatches

_MOST = 5000
"""Patches of each generation: those that are not asked for while so many others are computed are
dropped."""

_Key = tuple[int, int, bytes]
_Known = tuple[Shape, Shape, FloatArray]


class KnownPatches:
    """The last patches by the identity of the ``shapes``, which they keep alive, and the bits of
    how the pair is placed. Those of shapes that are no longer there are dropped: they would keep
    every state of a mesh that is edited."""

    def __init__(self, shapes: Sequence[Shape], before: KnownPatches | None = None) -> None:
        self._new: dict[_Key, _Known] = {}
        self._old: dict[_Key, _Known] = {}
        if before is not None:
            there = {id(shape) for shape in shapes}
            every = before._old | before._new
            self._old = {key: known for key, known in every.items() if there.issuperset(key[:2])}

    def of(
        self,
        shapes: Sequence[tuple[Shape, Shape]],
        placing: tuple[FloatArray, FloatArray, FloatArray],
        compute: Callable[[IntArray], PairPatches],
    ) -> PairPatches:
        """The patches of pairs of ``shapes`` (p,); ``placing``: rotations (3, 3, p), offsets (3, p)
        and limits (p,); ``compute`` gives those of some of the pairs."""
        rotation, offset, limit = placing
        rows = np.concatenate([rotation.reshape(9, -1), offset, limit[None]]).T.copy()
        keys = [(id(a), id(b), row.tobytes()) for (a, b), row in zip(shapes, rows, strict=True)]
        known = [self._new.get(key) or self._old.get(key) for key in keys]
        asked = np.array([k for k, each in enumerate(known) if each is None], dtype=np.int64)
        values = np.empty((len(keys), 8))
        if len(asked):
            found = compute(asked)
            values[asked] = np.concatenate(
                [found.distance[None], found.normal, found.centre, found.area[None]]
            ).T
        for k, (key, each) in enumerate(zip(keys, known, strict=True)):
            if each is None:
                each = *shapes[k], values[k].copy()
            else:
                values[k] = each[2]
            self._new[key] = each
        if len(self._new) > _MOST:
            self._new, self._old = {}, self._new
        distance, normal, centre, area = np.split(values.T, [1, 4, 7])
        return PairPatches(distance[0].copy(), normal.copy(), centre.copy(), area[0].copy())
