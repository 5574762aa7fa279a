"""Recording traced frames as tracks."""

from __future__ import annotations

import tempfile
from typing import IO

import numpy as np

from ...arrays import FloatArray
from ...frozen import frozen
from ...render.frame_result import FrameResult
from ...scene.values import Listener, Source, SourceKind
from .listener_tracks import ListenerTrack, Tracks, sorted_impacts, strengths


@frozen
class RenderedFrame:
    """The part of a `FrameResult` that is recorded."""

    number: int
    sources: tuple[Source, ...]
    listeners: tuple[Listener, ...]
    amplitudes: FloatArray
    block: FloatArray | None
    first_sample: int
    sample_rate: float


class TrackRecorder:
    """Records traced frames. Samples are written to a temporary file, which is removed with the
    tracks, to save memory."""

    def __init__(self) -> None:
        self._file: IO[bytes] = tempfile.TemporaryFile(prefix="haptic-tracks-")  # noqa: SIM115
        self._listeners: tuple[Listener, ...] = ()
        self._sample_rate = 0
        self._first = 0
        self._count = 0
        self._impacts: dict[str, tuple[float, list[float]]] = {}

    def add(self, result: FrameResult | RenderedFrame) -> None:
        """Add a frame. Raises ValueError unless it follows the frame before and has the same
        listeners."""
        if not self._sample_rate:
            self._listeners = result.listeners
            self._sample_rate = round(result.sample_rate)
        if [item.name for item in result.listeners] != [item.name for item in self._listeners]:
            raise ValueError(f"listeners: they change in frame {result.number}")
        for row, source in enumerate(result.sources):
            if source.kind is SourceKind.TEMPORARY and source.name not in self._impacts:
                self._impacts[source.name] = (
                    source.onset,
                    strengths(source, result.amplitudes[row]),
                )
        if result.block is None or not result.block.shape[1]:
            return
        if not self._count:
            self._first = result.first_sample
        elif result.first_sample != self._first + self._count:
            raise ValueError(f"number: frame {result.number} does not follow the one before")
        self._file.write(result.block.T.astype("<f4").tobytes())
        self._count += result.block.shape[1]

    def tracks(self) -> Tracks:
        """The recorded tracks."""
        start = self._first / (self._sample_rate or 1)
        felt = tuple(self._impacts.values())
        shape = self._count, len(self._listeners)
        self._file.flush()
        samples = (
            np.memmap(self._file, dtype="<f4", mode="r", shape=shape)
            if self._count and shape[1]
            else np.zeros(shape, dtype="<f4")
        )
        return Tracks(
            listeners=tuple(
                ListenerTrack(
                    item.name,
                    item.body_part,
                    sorted_impacts((time - start, row[number]) for time, row in felt),
                    item.device,
                )
                for number, item in enumerate(self._listeners)
            ),
            sample_rate=self._sample_rate or 1,
            samples=samples.T,
            start=start,
        )
