"""Where tagged objects and instances are."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from bpy.types import Object
from numpy.typing import NDArray

from ...core.arrays import BoolArray, FloatArray, IntArray
from .linkage import Link, Linkage
from .parented import ParentedPoses
from .tagged import TaggedLists
from .world_transforms import rigid_transforms


class Poses:
    """The world matrices (m, 16) of tagged objects and instances as they were taken over last, in
    the order of their rows, and the ``rigid`` transforms (m, 4, 4) in them. ``are_moved``: whether
    the last `follow` has taken over any."""

    def __init__(self) -> None:
        self.rigid = np.zeros((0, 4, 4))
        self.are_moved = False
        self._matrices = np.zeros((0, 16), dtype=np.float32)
        self._parented = ParentedPoses({})

    def with_some(self, numbers: IntArray, matrices: NDArray[np.float32]) -> NDArray[np.float32]:
        """All matrices (m, 16), of which some are now others."""
        every = self._matrices.copy()
        every[numbers] = matrices
        return every

    def carry(self, objects: Iterable[Object]) -> None:
        """Take over which of the tagged ``objects``, in order, are carried by others."""
        carried = _carried(list(objects))
        if carried != self._parented.carried:  # else poses stay what they were to the last bit
            self._parented = ParentedPoses(carried)

    def take(self, matrices: NDArray[np.float32], exact: bool) -> FloatArray:
        """Take over all matrices; the stretches (m, 6) in them."""
        self._matrices, self.are_moved = matrices, True
        self.rigid, stretches = rigid_transforms(matrices)
        self._parented.correct(self.rigid, exact)
        return stretches

    def follow(
        self, matrices: NDArray[np.float32], lists: TaggedLists, exact: bool
    ) -> dict[int, FloatArray]:
        """Take over what has moved, all if ``exact``: else an old matrix stays while a simulation
        at rest trembles. Returns the stretches by row that are others than in the ``lists``."""
        if exact:
            moved = np.arange(len(matrices))
            stretches = self.take(matrices, exact)
        else:
            moved = _moved(matrices, self._matrices, lists.still)
            self.are_moved = len(moved) > 0
            if not self.are_moved:
                return {}
            self._matrices[moved] = matrices[moved]
            self.rigid = self.rigid.copy()  # the old array belongs to the last reading
            self.rigid[moved], stretches = rigid_transforms(matrices[moved])
            self._parented.correct(self.rigid, exact)
        others = np.flatnonzero(differ(stretches, lists.stretches[moved]))
        rows = lists.rows[moved[others]].tolist()
        return dict(zip(rows, rounded(stretches[others]), strict=True))


def rounded(stretches: FloatArray) -> FloatArray:
    """Stretches (n, 6) to six digits."""
    digits = [float(f"{part:.6g}") for part in stretches.reshape(-1).tolist()]
    return np.array(digits).reshape(-1, 6)


def differ(stretches: FloatArray, known: FloatArray) -> BoolArray:
    """Whether stretches (n, 6) differ from those ``known`` (n, 6) by more than rounding, or are no
    numbers, (n,)."""
    limits = 1e-5 * np.abs(known)
    limits[:, 3:] = limits[:, :3].max(axis=1, keepdims=True)
    return np.asarray(~np.all(np.abs(stretches - known) <= limits, axis=1))


def _moved(
    matrices: NDArray[np.float32], before: NDArray[np.float32], limits: FloatArray
) -> IntArray:
    """Numbers (k,) of the matrices (n, 16) that differ from those ``before`` by more than
    ``limits`` (n, 16)."""
    others = np.flatnonzero((matrices != before).any(axis=1))
    beyond = ~(np.abs(matrices[others] - before[others]) <= limits[others]).all(axis=1)
    return others[beyond]


def _carried(objects: list[Object]) -> dict[int, int]:
    """By number of a tagged object that of the one that carries it: the first of its link, or that
    of the link above. Below an untagged root, as imports have it, the first one carries all."""
    linkage = Linkage()
    links = [linkage.root((obj, "")) for obj in objects]
    leaders: dict[Link | None, int] = {}
    for number, link in enumerate(links):
        leaders.setdefault(link, number)
    carried = {}
    for number, link in enumerate(links):
        above: Link | None = link
        while above is not None and leaders.setdefault(above, number) == number:
            above = linkage.above(above)
        if above is not None:
            carried[number] = leaders[above]
    return carried
