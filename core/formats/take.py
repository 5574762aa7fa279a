"""Traced frames gathered into tracks."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from typing import IO

import numpy as np

from ..frame_result import FrameResult
from ..scene import Listener, SourceKind
from ..signals import DEFAULT_IMPACT
from .tracks import ListenerTrack, Tracks


class Take:
    """Takes one traced frame after the other. Samples go to a file that vanishes with the tracks, so that length costs no memory."""

    def __init__(self) -> None:
        self._file: IO[bytes] = tempfile.TemporaryFile(prefix="haptic-tracks-")  # noqa: SIM115
        self._listeners: tuple[Listener, ...] = ()
        self._sample_rate = 0
        self._first = 0
        self._count = 0
        self._impacts: dict[str, tuple[float, list[float]]] = {}

    def add(self, result: FrameResult) -> None:
        """A frame. Raises ValueError where it does not follow the one before, or where the listeners have changed."""
        if not self._sample_rate:
            self._listeners, self._sample_rate = result.listeners, round(result.sample_rate)
        if [item.name for item in result.listeners] != [item.name for item in self._listeners]:
            raise ValueError(f"listeners: they change in frame {result.number}")
        for row, source in enumerate(result.sources):
            if source.kind is SourceKind.TEMPORARY and source.name not in self._impacts:
                peak = min((source.signal or DEFAULT_IMPACT).peak, 1.0)
                self._impacts[source.name] = (source.onset, np.minimum(result.gains[row] * peak, 1.0).tolist())
        if result.block is None or not result.block.shape[1]:
            return
        if not self._count:
            self._first = result.first_sample
        elif result.first_sample != self._first + self._count:
            raise ValueError(f"number: frame {result.number} does not follow the one before")
        self._file.write(result.block.T.astype("<f4").tobytes())
        self._count += result.block.shape[1]

    def tracks(self) -> Tracks:
        """All that was taken."""
        start = self._first / (self._sample_rate or 1)
        shape = (self._count, len(self._listeners))
        self._file.flush()
        samples = np.memmap(self._file, dtype="<f4", mode="r", shape=shape) if self._count and shape[1] else np.zeros(shape, dtype="<f4")
        return Tracks(
            listeners=tuple(
                ListenerTrack(item.name, item.body_part, self._impacts_at(number, start)) for number, item in enumerate(self._listeners)
            ),
            sample_rate=self._sample_rate or 1,
            samples=samples.T,
            start=start,
        )

    def _impacts_at(self, listener: int, start: float) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        """Times from the first sample and strengths of the impacts that reach a listener."""
        felt = sorted(
            (time - start, strengths[listener]) for time, strengths in self._impacts.values() if strengths[listener] > 0 and time >= start
        )
        return np.array(felt, dtype=np.float64).reshape(-1, 2)


def tracks_of(results: Iterable[FrameResult]) -> Tracks:
    """The tracks of consecutive frames. Raises ValueError as `Take.add` does."""
    take = Take()
    for result in results:
        take.add(result)
    return take.tracks()
