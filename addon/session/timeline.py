"""Plays the timeline frame by frame, with the add-on's own frame handler doing the tracing, and keeps what was rendered."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from contextlib import closing
from dataclasses import dataclass

import bpy
import numpy as np
from bpy.types import Scene

from ...core.arrays import FloatArray
from ...core.render.frame_result import FrameResult
from ...core.scene.values import Source
from ..blender.time import seconds_of
from ..changes.suspension import stepped, suspended
from ..scene_reader.problem import Problem
from ..scene_reader.reading import Reading
from . import session


@dataclass(frozen=True, slots=True)
class ImpactFelt:
    """A temporary source at the frame where it began: its gains at the listeners, amplitude included, and the objects of its best paths."""

    source: Source
    gains: FloatArray
    paths: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, slots=True)
class Played:
    """What playing a frame range gave. ``samples`` (l, n) of ``listeners``; ``start`` [s] of the first sample; per frame (f,) Blender's own
    and the tracer's milliseconds."""

    listeners: tuple[str, ...]
    body_parts: tuple[str, ...]
    samples: FloatArray
    sample_rate: float
    start: float
    impacts: tuple[ImpactFelt, ...]
    blender_milliseconds: FloatArray
    tracing_milliseconds: FloatArray
    last: FrameResult
    last_reading: Reading
    liveliest: FrameResult  # the frame of the strongest impact; the last one where there was none


@dataclass(frozen=True, slots=True)
class Step:
    """A traced frame, and how long Blender took for it."""

    result: FrameResult
    blender_milliseconds: float
    tracing_milliseconds: float


def results(scene: Scene, start: int, end: int) -> Generator[FrameResult, None, None]:
    """Trace the frames ``start`` to ``end`` in order. Each is traced while Blender evaluates the next one, in which the scene stands when
    it comes; in the end, the scene's frame is what it was.

    A simulation that begins earlier and is not baked runs up to ``start`` first. Raises ValueError in words where a frame can't be traced,
    or where the listeners change on the way.
    """
    result: FrameResult | None = None
    own = session.of(scene)
    with closing(_frames(scene, start, end)) as frames:
        for frame in frames:
            if frame > start:
                result = _checked(frame - 1, own.previous, own.problems, result)
                yield result
            if frame == end:
                yield _checked(frame, session.result_of(scene), own.problems, result)


def steps(scene: Scene, start: int, end: int, listeners_may_change: bool = False) -> Generator[Step, None, None]:
    """The same, the scene standing in the frame that comes."""
    result: FrameResult | None = None
    began = time.perf_counter()
    with closing(_frames(scene, start, end)) as frames:
        for frame in frames:
            before = None if listeners_may_change else result
            result = _checked(frame, session.result_of(scene), session.problems_of(scene), before)
            total, traced = 1000 * (time.perf_counter() - began), sum(result.milliseconds.values())
            yield Step(result, total - traced, traced)
            began = time.perf_counter()


def _frames(scene: Scene, start: int, end: int) -> Generator[int, None, None]:
    """Let Blender come to the frames in order, the tracing of each begun when it is given."""
    before = scene.frame_current
    try:
        for frame in range(_simulation_start(scene, start), start):
            with suspended():
                scene.frame_set(frame)
        session.of(scene).frame = None  # a fresh start, whatever was traced before
        for frame in range(start, end + 1):
            with stepped(scene):
                scene.frame_set(frame)
            yield frame
    finally:
        scene.frame_set(before)


def _simulation_start(scene: Scene, start: int) -> int:
    """The frame from which rigid bodies have to be simulated to stand right at ``start``."""
    world = scene.rigidbody_world
    if world is None or not world.enabled or world.point_cache.is_baked:
        return start
    return min(world.point_cache.frame_start, start)


def play(scene: Scene, start: int, end: int, progress: Callable[[int], None] = lambda frame: None) -> Played:
    """What playing the frames ``start`` to ``end`` gives, see `steps`. ``progress`` is told every frame."""
    blocks: list[FloatArray] = []
    blender, tracing = [], []
    impacts: list[ImpactFelt] = []
    result: FrameResult | None = None
    liveliest: FrameResult | None = None
    reading: Reading | None = None
    with closing(steps(scene, start, end)) as played:
        for step in played:
            result = step.result
            reading = session.of(scene).reading
            blender.append(step.blender_milliseconds)
            tracing.append(step.tracing_milliseconds)
            impacts += _new_impacts(result)
            if result.impacts and (liveliest is None or _strength(result) > _strength(liveliest)):
                liveliest = result
            if result.block is not None:
                blocks.append(result.block)
            progress(result.number)
    if result is None or reading is None:
        raise ValueError(f"The frame range {start} to {end} is empty")
    return Played(
        listeners=tuple(listener.name for listener in result.listeners),
        body_parts=tuple(listener.body_part for listener in result.listeners),
        samples=np.concatenate(blocks, axis=1) if blocks else np.zeros((len(result.listeners), 0)),
        sample_rate=result.sample_rate,
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


def _checked(frame: int, result: FrameResult | None, problems: tuple[Problem, ...], before: FrameResult | None) -> FrameResult:
    if result is None or result.number != frame:
        raise ValueError(f"Frame {frame} can't be traced: {problems[0].message if problems else 'no object is tagged'}")
    if before is not None and [item.name for item in before.listeners] != [item.name for item in result.listeners]:
        raise ValueError(f"The listeners change at frame {frame}: keep them all switched on, and set Gain to 0 where nothing is to be felt")
    return result


def _new_impacts(result: FrameResult) -> list[ImpactFelt]:
    """The temporary sources that this frame began."""
    first = len(result.sources) - len(result.impacts)
    return [
        ImpactFelt(result.sources[s], result.gains[s], tuple(result.path_objects(s, i) for i in range(len(result.listeners))))
        for s in range(first, len(result.sources))
    ]


def open_blend(path: str) -> Scene:
    """Open a .blend file without running its scripts, and return its scene. Raises ValueError where it can't be opened."""
    try:
        bpy.ops.wm.open_mainfile(filepath=path, use_scripts=False, load_ui=False)
    except RuntimeError as error:
        raise ValueError(f"{path}: {str(error).strip().removeprefix('Error: ')}") from None
    return bpy.context.scene
