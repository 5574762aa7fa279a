"""Plays the timeline frame by frame: each is read after Blender has finished it."""

from __future__ import annotations

import math
import time
from collections.abc import Generator
from contextlib import closing
from dataclasses import replace
from functools import cache
from itertools import product

import bpy
from bpy.types import Scene

from ...core.events.frame import EXACT_FRAMES
from ...core.frozen import frozen
from ...core.render.frame_result import FrameResult
from ...core.render.groups import MAX_DELAY
from ...core.signals import DEFAULT_IMPACT, IMPACT_MATERIALS, Signal, impact_template
from ..blender.time import frame_seconds
from ..blender.words import report_text
from ..changes.revisions import SCENE
from ..changes.suspension import stepped, suspended
from ..scene_reader.problem import Problem, why_untraced
from ..scene_reader.reader import SceneReader
from . import session

_MOTION_FRAMES = 6
"""Poses that motion is estimated from, and the one that they lead to."""


@frozen
class TracedFrame:
    """A traced frame, and how long Blender's evaluation and the tracing took."""

    result: FrameResult
    blender_milliseconds: float
    tracing_milliseconds: float


def results(scene: Scene, start: int, end: int) -> Generator[FrameResult, None, None]:
    """Trace the frames ``start`` to ``end`` in order. Each is traced while Blender evaluates the
    next one, which is then the scene's current frame; at the end, the scene's frame is restored.

    A simulation that begins earlier and is not baked is computed up to ``start`` first; with
    sliding, rolling or triggers, the earlier frames that they depend on are traced. Raises
    ValueError, with a message for the user, if a frame cannot be traced, or if the listeners
    change.
    """
    result: FrameResult | None = None
    own = session.of(scene)
    with closing(_frames(scene, start, end)) as frames:
        for frame in frames:
            if frame > start:
                result = _checked(frame - 1, own.previous, own.failure, result)
                yield _from(start, result)
            if frame == end:
                yield _from(start, _checked(frame, session.result_of(scene), own.failure, result))


def steps(
    scene: Scene, start: int, end: int, listeners_may_change: bool = False, looks_back: bool = True
) -> Generator[TracedFrame, None, None]:
    """Trace the frames ``start`` to ``end`` in order. Each is the scene's current frame as it is
    yielded; at the end, the scene's frame is restored.

    Args:
        scene: to trace.
        start: first frame.
        end: last frame.
        listeners_may_change: from frame to frame.
        looks_back: earlier frames are traced that triggers, sliding and rolling depend on.
    """
    result: FrameResult | None = None
    own = session.of(scene)
    began = time.perf_counter()
    with closing(_frames(scene, start, end, looks_back)) as frames:
        for frame in frames:
            before = None if listeners_may_change else result
            result = _checked(frame, session.result_of(scene), own.failure, before)
            total = 1000 * (time.perf_counter() - began)
            traced = sum(result.milliseconds.values())
            yield TracedFrame(_from(start, result), total - traced, traced)
            began = time.perf_counter()


def _frames(
    scene: Scene, start: int, end: int, looks_back: bool = True
) -> Generator[int, None, None]:
    """Step Blender through the frames in order; the trace of each has begun when it is yielded."""
    before = scene.frame_current
    try:
        first = tracing_start(scene, start) if looks_back else start
        for frame in range(simulation_start(scene, first), first):
            with suspended():
                scene.frame_set(frame)
        session.of(scene).last = None  # independent of earlier traces
        session.of(scene).reader.reread({SCENE})  # also of joints that scripts have edited
        for frame in range(first, end + 1):
            set_frame(scene, frame)
            if frame >= start:
                yield frame
    finally:
        scene.frame_set(before)


def set_frame(scene: Scene, frame: int) -> None:
    """Set a frame, read it after Blender has finished it, and begin to trace it, whatever the
    settings of the preview."""
    with stepped(scene):
        scene.frame_set(frame)
        session.begin_stepped(scene)


def sounding_seconds(scene: Scene) -> float:
    """For how long an impact or trigger of a scene may still matter, at most: the longest template
    at its slowest, the longest refractory time, and the delay of the waves on their way to the
    listeners."""
    reading = SceneReader().read(scene, bpy.context.evaluated_depsgraph_get())
    rules = reading.contact_settings.impact_rules()
    durations = [
        _longest_template(),
        *(rule.template.duration for rule in rules if isinstance(rule.template, Signal)),
    ]
    durations += [
        item.signal.duration
        for item in reading.sources
        if item.triggers is not None and item.signal is not None
    ]
    seconds = max(durations) / min(rule.slowest for rule in rules)
    seconds += max(limits.refractory for limits in reading.contact_settings.all_limits())
    slow = (
        (item.propagation.spectrum.wave_speed, body.shape)
        for item, body in zip(reading.objects, reading.bodies, strict=True)
    )
    return seconds + min(
        sum(math.dist(*shape.local_bounds) / speed for speed, shape in slow if speed), MAX_DELAY
    )


@cache
def _longest_template() -> float:
    """Duration of the longest impact without a rule of its own [s]."""
    return max(
        signal.duration
        for signal in (
            DEFAULT_IMPACT,
            *(impact_template(*pair) for pair in product(IMPACT_MATERIALS, repeat=2)),
        )
    )


def warm_start(scene: Scene, first: int, seconds: float) -> int:
    """The frame from which frames must be traced for ``first`` to be independent of earlier ones:
    motion is estimated from the last poses, and ``seconds``, as of `sounding_seconds`, cover the
    refractory time and the impacts and triggers that still sound. It is a multiple of
    `EXACT_FRAMES`, at which nothing is kept from earlier frames; one multiple earlier if something
    may slide or roll, because `SlidingAndRolling` depends on the block of frames before its own."""
    blocks = (first - _MOTION_FRAMES - math.ceil(seconds / frame_seconds(scene))) // EXACT_FRAMES
    return (blocks - bool(scene.haptics.textures.items)) * EXACT_FRAMES


def simulation_start(scene: Scene, start: int) -> int:
    """The frame from which the simulation must run so that rigid bodies are in place at ``start``:
    ``start`` itself if it moves none."""
    world = scene.rigidbody_world
    bodies = (obj.rigid_body for obj in scene.objects)
    if (
        world is None
        or not world.enabled
        or world.point_cache.is_baked
        or not any(body and body.type == "ACTIVE" for body in bodies)
    ):
        return start
    return min(world.point_cache.frame_start, start)


def tracing_start(scene: Scene, start: int) -> int:
    """The first frame that must be traced for the triggers, sliding and rolling of ``start``."""
    if start <= scene.frame_start:
        return start
    shoots = any(
        obj.haptics.source.enabled and obj.haptics.source.one_shot for obj in scene.objects
    )
    if not shoots and not scene.haptics.textures.items:
        return start
    return max(warm_start(scene, start, sounding_seconds(scene)), scene.frame_start)


def _from(start: int, result: FrameResult) -> FrameResult:
    """A result, without samples from before the frame ``start``."""
    return (
        replace(result, block=None)
        if result.number == start and result.block is not None
        else result
    )


def _checked(
    frame: int,
    result: FrameResult | None,
    problems: tuple[Problem, ...],
    before: FrameResult | None,
) -> FrameResult:
    if result is None or result.number != frame:
        raise ValueError(report_text("Frame {} can't be traced: {}", frame, why_untraced(problems)))
    if before is not None and [item.name for item in before.listeners] != [
        item.name for item in result.listeners
    ]:
        raise ValueError(
            report_text(
                "The listeners change at frame {}: keep them all switched on, and set Gain to 0 "
                "where nothing is to be felt",
                frame,
            )
        )
    return result
