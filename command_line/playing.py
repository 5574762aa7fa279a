"""Playing a range of frames of a Blender file: the samples of all listeners, the impacts and the
run times."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing

import numpy as np
from bpy.types import Scene

from ..addon.blender.time import seconds_of
from ..addon.scene_reader.reading import Reading
from ..addon.session import session
from ..addon.session.timeline import steps
from ..core.arrays import FloatArray
from ..core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from ..core.frozen import frozen
from ..core.render.frame_result import FrameResult
from ..core.scene.values import Source


@frozen
class ImpactFelt:
    """A temporary source at the frame where it began: the amplitudes with which it arrives at the
    listeners, and the objects of its best paths."""

    source: Source
    amplitudes: FloatArray
    paths: tuple[tuple[str, ...], ...]


@frozen
class Played:
    """The result of playing a range of frames. ``samples`` (l, n) of ``listeners``; ``start`` [s]
    of the first sample; per frame (f,) Blender's own and the tracer's milliseconds."""

    listeners: tuple[str, ...]
    samples: FloatArray
    start: float
    impacts: tuple[ImpactFelt, ...]
    blender_milliseconds: FloatArray
    tracing_milliseconds: FloatArray
    last: FrameResult
    last_reading: Reading
    liveliest: FrameResult  # the frame of the strongest impact; the last one without impacts

    def tracks(self) -> Tracks:
        """The samples as tracks."""
        listeners = tuple(map(ListenerTrack, self.listeners))
        return Tracks(listeners, round(self.last.sample_rate), self.samples, self.start)


def play(
    scene: Scene, start: int, end: int, progress: Callable[[int], None] = lambda frame: None
) -> Played:
    """Play the frames ``start`` to ``end``, see `steps`, and the one after them, with which the
    samples end. ``progress`` is called with every frame."""
    blocks: list[FloatArray] = []
    blender, tracing = [], []
    impacts: list[ImpactFelt] = []
    result: FrameResult | None = None
    liveliest: FrameResult | None = None
    reading: Reading | None = None
    with closing(steps(scene, start, end + 1)) as played:
        for step in played:
            if step.result.block is not None:
                blocks.append(step.result.block)
            progress(step.result.number)
            if step.result.number > end:
                break
            result = step.result
            reading = session.of(scene).reading
            blender.append(step.blender_milliseconds)
            tracing.append(step.tracing_milliseconds)
            impacts += _new_impacts(result)
            if result.impacts and (liveliest is None or _strength(result) > _strength(liveliest)):
                liveliest = result
    if result is None or reading is None:
        raise ValueError(f"The frame range {start} to {end} is empty")
    return Played(
        listeners=tuple(listener.name for listener in result.listeners),
        samples=np.concatenate(blocks, axis=1) if blocks else np.zeros((len(result.listeners), 0)),
        start=seconds_of(scene, start),
        impacts=tuple(impacts),
        blender_milliseconds=np.array(blender),
        tracing_milliseconds=np.array(tracing),
        last=result,
        last_reading=reading,
        liveliest=liveliest or result,
    )


def _strength(result: FrameResult) -> float:
    return max(impact.energy for impact in result.impacts)


def _new_impacts(result: FrameResult) -> list[ImpactFelt]:
    """The temporary sources that this frame began."""
    first = len(result.sources) - len(result.impacts)
    return [
        ImpactFelt(
            result.sources[s],
            result.amplitudes[s],
            tuple(result.path_objects(s, i) for i in range(len(result.listeners))),
        )
        for s in range(first, len(result.sources))
    ]
