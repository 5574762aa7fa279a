"""Rendered samples of the listeners, with the impacts among them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import field

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...frozen import frozen
from ...perception import FullScale
from ...scene.values import Source
from ..io.catalogue import MAX_SAMPLE_RATE

CHUNK = 2**18
"""Samples that are processed at once."""
PIECE = 2**14
"""Samples of one listener that are processed at once where the intermediate results are to stay in
the processor's cache."""


def strengths(source: Source, amplitudes: FloatArray) -> list[float]:
    """Peak of an impact's vibration at each listener, at most 1; ``amplitudes`` (l,): with which it
    arrives."""
    peak = min(source.emitted.peak, 1.0)
    return list(map(float, np.minimum(amplitudes * peak, 1.0)))


def sorted_impacts(impacts: Iterable[tuple[float, float]]) -> FloatArray:
    """Impacts (k, 2) of time and strength, sorted by time, without those of strength 0 and those
    before the first sample."""
    return np.array(
        sorted((time, strength) for time, strength in impacts if time >= 0 and strength > 0),
        dtype=np.float64,
    ).reshape(-1, 2)


@frozen(eq=False)
class ListenerTrack:
    """The listener of a track.

    ``impacts`` (k, 2): time in seconds from the start of the tracks, ascending, and strength, the
    peak of the impact's signal at this listener, in [0, 1]. Their vibration is part of the samples.
    ``device``: the calibration of the listener's device, if known.
    """

    name: str
    body_part: str = ""
    impacts: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    device: FullScale | None = None

    def __post_init__(self) -> None:
        impacts = np.asarray(self.impacts, dtype=np.float64).reshape(-1, 2)
        if not (np.isfinite(impacts).all() and (impacts >= 0).all() and (impacts[:, 1] <= 1).all()):
            raise ValueError(
                "impacts: times must be finite and not negative, strengths from 0 to 1"
            )
        if (np.diff(impacts[:, 0]) < 0).any():
            raise ValueError("impacts: times must ascend")
        object.__setattr__(self, "impacts", impacts)


class Row:
    """The samples (n,) of one listener at ``sample_rate`` (hertz), read in pieces and clipped to
    ±1."""

    def __init__(self, samples: NDArray[np.floating], sample_rate: int) -> None:
        self._samples = samples
        self.count: int = len(samples)
        self.sample_rate = sample_rate

    @property
    def duration(self) -> float:
        """Seconds."""
        return self.count / self.sample_rate

    def read(self, first: int, last: int) -> FloatArray:
        """The samples from index ``first`` to before ``last``, shape (last - first,); 0 beyond the
        ends of the track."""
        begin = min(max(first, 0), self.count)
        end = min(max(last, 0), self.count)
        result = np.zeros(last - first)
        np.clip(self._samples[begin:end], -1.0, 1.0, out=result[begin - first : end - first])
        return result


@frozen(eq=False)
class Tracks:
    """``samples`` (n_listeners, n) at ``sample_rate`` (hertz), nominal range [-1, 1]; the first is
    at ``start`` seconds of the scene.

    The array may be on disk (`numpy.memmap`), since it is read in pieces.
    """

    listeners: tuple[ListenerTrack, ...]
    sample_rate: int
    samples: NDArray[np.floating]
    start: float = 0.0

    def __post_init__(self) -> None:
        if self.samples.ndim != 2 or len(self.samples) != len(self.listeners):
            raise ValueError(
                f"samples: expected shape ({len(self.listeners)}, n), got {self.samples.shape}"
            )
        if (
            self.sample_rate != int(self.sample_rate)
            or not 1 <= self.sample_rate <= MAX_SAMPLE_RATE
        ):
            raise ValueError(
                f"sample_rate: must be a whole number from 1 to {MAX_SAMPLE_RATE}, got "
                f"{self.sample_rate!r}"
            )
        object.__setattr__(self, "sample_rate", int(self.sample_rate))
        names = [listener.name for listener in self.listeners]
        if len(set(names)) < len(names):
            raise ValueError("listeners: names must differ")
        if not np.isfinite(self.start):
            raise ValueError(f"start: must be finite, got {self.start!r}")
        for block in self.blocks():
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

    def row(self, number: int) -> Row:
        """The samples of one listener."""
        return Row(self.samples[number], self.sample_rate)

    def blocks(self) -> Iterator[NDArray[np.floating]]:
        """The samples in pieces (n_listeners, k)."""
        size = max(CHUNK // max(len(self.listeners), 1), 1)
        for first in range(0, self.count, size):
            yield self.samples[:, first : first + size]

    def clipped(self) -> int:
        """Number of samples beyond ±1, which formats of fixed range clip."""
        return sum(int(np.count_nonzero(np.abs(block) > 1)) for block in self.blocks())
