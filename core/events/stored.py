"""Events of frames that were traced, from which such a frame sounds again."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray
from ..frozen import frozen
from .impacts import ActiveImpact
from .one_shots import Shot
from .rubbing import FrameRubbing

_MOST_FRAMES = 4096

_UNMOVED = 1e-5
"""Difference of poses, relative to the largest coordinate, below which a body has not moved: poses
are float32."""


@frozen
class FrameEvents:
    """A snapshot of the events of one frame.

    Attributes:
        start: time at which the frame begins [s].
        impacts: the active ones.
        poses: (k, 2, 3, 4) of both bodies of each of these, then of each pair that slides or rolls,
            at the end of the frame.
        shots: the active one-shots.
        rubbed: what slides and rolls.
    """

    start: float
    impacts: tuple[ActiveImpact, ...]
    poses: FloatArray
    shots: tuple[Shot, ...] = ()
    rubbed: FrameRubbing | None = None

    @classmethod
    def of(
        cls,
        start: float,
        transforms: FloatArray,
        impacts: tuple[ActiveImpact, ...],
        shots: tuple[Shot, ...],
        rubbed: FrameRubbing | None,
    ) -> FrameEvents | None:
        """The snapshot of a frame with the bodies at ``transforms`` (n, 4, 4); None if nothing is
        active."""
        if not impacts and not shots and rubbed is None:
            return None
        return cls(start, impacts, _touched_poses(impacts, rubbed, transforms), shots, rubbed)

    def bodies_unmoved(self, transforms: FloatArray) -> bool:
        """Whether the struck and rubbing bodies are at the same ``poses`` in ``transforms`` (n, 4,
        4), those of all bodies."""
        poses = _touched_poses(self.impacts, self.rubbed, transforms)
        limit = _UNMOVED * max(1.0, float(np.abs(poses).max(initial=0.0)))
        return bool(np.allclose(poses, self.poses, rtol=0.0, atol=limit))


def _touched_poses(
    impacts: Sequence[ActiveImpact], rubbed: FrameRubbing | None, transforms: FloatArray
) -> FloatArray:
    pairs = [*(item.impact.objects for item in impacts), *(() if rubbed is None else rubbed.pairs)]
    return transforms[np.array(pairs, dtype=np.int64).reshape(-1, 2), :3]


class StoredEvents:
    """The events of the last frames, as long as what causes them stays the same."""

    def __init__(self) -> None:
        self._frames: dict[int, FrameEvents] = {}
        self._causes: object = None

    def __len__(self) -> int:
        return len(self._frames)

    def clear(self) -> None:
        """Drop all events."""
        self._frames.clear()

    def of(self, number: int) -> FrameEvents | None:
        """The events of a frame."""
        return self._frames.get(number)

    def heed(self, causes: object) -> None:
        """Drop all events if they have other ``causes``."""
        if self._frames and self._causes != causes:
            self.clear()

    def store(self, number: int, events: FrameEvents | None, causes: object) -> None:
        """Store the events of a frame, which are due to these ``causes``."""
        self._frames.pop(number, None)
        if events is not None:
            self._causes = causes
            self._frames[number] = events
            if len(self._frames) > _MOST_FRAMES:
                del self._frames[next(iter(self._frames))]
