"""A bake as a job in steps, so that Blender stays responsive: frame after frame, then the track."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import closing

import bpy
from bpy.types import Scene

from ...core.scene.values import Mode
from ..blender.job import Job, Report
from ..blender.words import TranslatedError, report_text
from ..changes.redraw import redraw_viewports
from ..scene_reader.digest import digest_of, motion_of
from ..scene_reader.kept_impacts import text_of_impacts
from ..session import session, timeline
from . import storage
from .track import BakeRecorder, check_size


def bake_job(scene: Scene) -> Job:
    """The bake of a scene's range. Until the last frame is traced the scene is unchanged, and
    cancelling restores its frame.

    Raises ValueError, with a message for the user, if the range is empty; the steps raise it if a
    frame cannot be traced, if there is no listener, and if the track would be too large.
    """
    first, last = scene.frame_start, scene.frame_end
    if last < first:
        raise TranslatedError("The frame range {} to {} is empty", first, last)
    count = last - first + 1

    def reports(_: Job) -> list[Report]:
        done = report_text("1 frame baked") if count == 1 else report_text("{} frames baked", count)
        return [({"INFO"}, done)]

    return Job("Baking", count, _steps(scene, first, last), reports)


def _steps(scene: Scene, first: int, last: int) -> Generator[None, None, None]:
    recorder = BakeRecorder()
    digest = digest_of(scene)
    motion = motion_of(scene)
    own = session.of(scene)
    frame_duration = scene.render.fps_base / scene.render.fps
    with closing(timeline.results(scene, first, last + 1)) as results:
        for result in results:
            if not recorder.frame_count:
                if not result.listeners:
                    raise TranslatedError("There is no listener: add one to feel something")
                check_size(
                    len(result.listeners), last - first + 1, frame_duration, result.sample_rate
                )
            kept = own.tracer.collisions.stored.of(result.number)
            recorder.add(
                result,
                "" if kept is None else text_of_impacts(result.number, kept, motion),
                Mode(scene.haptics.mode),
            )
            yield
    track = recorder.track(digest, frame_duration)
    del recorder
    storage.keep(scene, track)
    bpy.ops.ed.undo_push(message="Bake Haptics")
    redraw_viewports()
