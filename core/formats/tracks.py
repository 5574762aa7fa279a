"""What the listeners feel: rendered samples with the impacts among them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

CHUNK = 2**18
"""Samples of a listener that are handled at once."""
MAX_SAMPLE_RATE = 192_000


def _no_impacts() -> FloatArray:
    return np.zeros((0, 2))


@dataclass(frozen=True, slots=True, eq=False)
class ListenerTrack:
    """Whose track it is. ``impacts`` (k, 2): time in seconds from the tracks' beginning, ascending, and strength, the peak that the
    impact's signal reaches at this listener, in [0, 1]. Their vibration is part of the samples."""

    name: str
    body_part: str = ""
    impacts: FloatArray = field(default_factory=_no_impacts)

    def __post_init__(self) -> None:
        impacts = np.asarray(self.impacts, dtype=np.float64).reshape(-1, 2)
        if not (np.isfinite(impacts).all() and (impacts >= 0).all() and (impacts[:, 1] <= 1).all()):
            raise ValueError("impacts: times must be finite and not negative, strengths from 0 to 1")
        if (np.diff(impacts[:, 0]) < 0).any():
            raise ValueError("impacts: times must ascend")
        object.__setattr__(self, "impacts", impacts)


@dataclass(frozen=True, slots=True, eq=False)
class Tracks:
    """``samples`` (n_listeners, n) at ``sample_rate`` a second; the first is at ``start`` seconds of the scene.

    Nominal range [-1, 1]. Any array will do, one on disk (`numpy.memmap`) too: it is only ever looked at in pieces.
    """

    listeners: tuple[ListenerTrack, ...]
    sample_rate: int
    samples: NDArray[np.floating]
    start: float = 0.0

    def __post_init__(self) -> None:
        if self.samples.ndim != 2 or len(self.samples) != len(self.listeners):
            raise ValueError(f"samples: expected shape ({len(self.listeners)}, n), got {self.samples.shape}")
        if self.sample_rate != int(self.sample_rate) or not 1 <= self.sample_rate <= MAX_SAMPLE_RATE:
            raise ValueError(f"sample_rate: must be a whole number from 1 to {MAX_SAMPLE_RATE}, got {self.sample_rate!r}")
        object.__setattr__(self, "sample_rate", int(self.sample_rate))
        names = [listener.name for listener in self.listeners]
        if len(set(names)) < len(names):
            raise ValueError("listeners: names must differ")
        if not np.isfinite(self.start):
            raise ValueError(f"start: must be finite, got {self.start!r}")
        for _, block in self.blocks():
            if not np.isfinite(block).all():
                raise ValueError("samples: must be finite")

    @property
    def count(self) -> int:
        """Samples of each listener."""
        return int(self.samples.shape[1])

    @property
    def duration(self) -> float:
        """Seconds."""
        return self.count / self.sample_rate

    def blocks(self) -> Iterator[tuple[int, NDArray[np.floating]]]:
        """The samples in pieces (n_listeners, k) that fit in memory, each with the number of its first sample."""
        size = max(CHUNK // max(len(self.listeners), 1), 1)
        for first in range(0, self.count, size):
            yield first, self.samples[:, first : first + size]

    def clipped(self) -> int:
        """How many samples lie beyond ±1: a target of fixed range cuts them."""
        return sum(int(np.count_nonzero(np.abs(block) > 1)) for _, block in self.blocks())
