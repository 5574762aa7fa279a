"""Poses of many objects at one moment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ...arrays import IntArray

PoseRow = tuple[float, float, float, float, float, float, float]

POSE_DIGITS = 5
"""Decimals of recorded poses. Gains do not depend on them, since contacts are recorded as well."""
PER_UNIT = 10**POSE_DIGITS


class Poses(Mapping[str, PoseRow]):
    """Poses by object, stored as integers (n, 7) in units of 1e-5: a seventh of the memory of a dictionary of tuples."""

    __slots__ = ("_rows", "names", "ticks")

    def __init__(self, names: tuple[str, ...], ticks: IntArray) -> None:
        self.names, self.ticks = names, ticks
        self._rows: dict[str, int] | None = None

    @classmethod
    def of(cls, poses: Mapping[str, PoseRow]) -> Poses:
        """The poses rounded to 1e-5."""
        if isinstance(poses, Poses):
            return poses
        values = np.array(list(poses.values()), dtype=np.float64).reshape(-1, 7)
        return cls(tuple(poses), np.rint(values * PER_UNIT).astype(np.int64))

    def __getitem__(self, name: str) -> PoseRow:
        if self._rows is None:
            self._rows = {key: row for row, key in enumerate(self.names)}
        return pose_row(self.ticks[self._rows[name]])

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)


def pose_row(ticks: IntArray) -> PoseRow:
    """A pose from its integers."""
    a, b, c, d, e, f, g = (ticks / PER_UNIT).tolist()
    return a, b, c, d, e, f, g
