"""Axes and units of an engine, converted to those of haptic scenes (right-handed, z up, metres) and
back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...core.arrays import FloatArray

_AXES = {
    ("z", "right"): ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    ("y", "right"): ((1, 0, 0), (0, 0, -1), (0, 1, 0)),  # Godot, glTF, three.js
    ("y", "left"): ((1, 0, 0), (0, 0, 1), (0, 1, 0)),  # Unity
    ("z", "left"): ((1, 0, 0), (0, -1, 0), (0, 0, 1)),  # Unreal
}
"""Rows of the matrix from an engine's axes to those of scenes, by its up axis and handedness."""


@dataclass(frozen=True)
class Convention:
    """``up``: the axis that points up, y or z. ``handedness``: right or left. ``metres_per_unit``:
    length of the engine's unit."""

    up: str = "z"
    handedness: str = "right"
    metres_per_unit: float = 1.0

    @cached_property
    def _axes(self) -> FloatArray:
        return np.array(_AXES[self.up, self.handedness], dtype=np.float64)

    @cached_property
    def is_own(self) -> bool:
        """Whether it is the convention of scenes."""
        return self == Convention()

    def position(self, position: Sequence[float]) -> list[float]:
        """A position of the engine in metres, in the axes of scenes."""
        placed: list[float] = (
            self._axes @ np.asarray(position, dtype=np.float64) * self.metres_per_unit
        ).tolist()
        return placed

    def position_back(self, position: Sequence[float]) -> list[float]:
        """A position of a scene in the engine's axes and unit."""
        placed: list[float] = (
            self._axes.T @ np.asarray(position, dtype=np.float64) / self.metres_per_unit
        ).tolist()
        return placed

    def direction(self, direction: Sequence[float]) -> list[float]:
        """A direction of the engine in the axes of scenes."""
        turned: list[float] = (self._axes @ np.asarray(direction, dtype=np.float64)).tolist()
        return turned

    def poses(self, poses: FloatArray) -> FloatArray:
        """Poses (n, 7) of the engine: x, y, z, then the rotation w, x, y, z, in the axes of scenes.

        A rotation R becomes M R M^-1, whose quaternion has the vector part det(M) M v.
        """
        turn = np.linalg.det(self._axes) * self._axes
        return np.column_stack(
            [
                poses[:, :3] @ self._axes.T * self.metres_per_unit,
                poses[:, 3:4],
                poses[:, 4:] @ turn.T,
            ]
        )
