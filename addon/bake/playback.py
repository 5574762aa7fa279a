"""Playback of a baked scene, whose frames come from the track, and comparison of the track with the scene."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import bpy
from bpy.types import Scene

from ...core.render.frame_result import FrameResult
from ...core.render.history import SECONDS
from ..changes import revisions
from ..changes.events import file_changed
from ..changes.redraw import redraw_sidebars, redraw_viewports
from ..scene_reader.digest import Change, changes, digest_of, words_for
from ..session import session
from . import storage
from .track import HapticTrack

_REST = 20.0  # pause after a comparison of scene and track, as a multiple of its duration


@dataclass(slots=True)
class _Compared:
    """When a scene was last compared with its track, which is known by its stamp, how long that took, and what had changed."""

    stamp: str
    version: int
    at: float
    seconds: float
    changes: tuple[Change, ...]


_compared: dict[int, _Compared] = {}  # by session id of the scene
_to_compare: set[int] = set()  # session ids of scenes whose panel waits for a comparison


def plays(scene: Scene) -> bool:
    """Whether the current frame comes from the track."""
    track = storage.played_track(scene)
    return track is not None and track.frame_start <= scene.frame_current <= track.frame_end


def play(scene: Scene) -> bool:
    """Show the current frame from the track. Returns False if playback of the track is off or the frame was not baked."""
    started = time.perf_counter()
    track = storage.played_track(scene)
    result = None if track is None else track.result(scene.frame_current)
    if track is None or result is None:
        return False
    result = replace(result, milliseconds={"read_track": 1000 * (time.perf_counter() - started)})
    session.show(scene, result, track.samples_until(scene.frame_current, SECONDS))
    return True


def keep_up(scene: Scene) -> bool:
    """Show the current frame of the track after an edit, undo or redo. Returns False if the frame is not played from the track."""
    if not plays(scene):
        return False
    result = session.result_of(scene)
    return is_from_track(result, scene.frame_current) or play(scene)


def is_from_track(result: FrameResult | None, frame: int) -> bool:
    """Whether a result is this frame, read from a track."""
    return result is not None and result.number == frame and "read_track" in result.milliseconds


def show_current(scene: Scene) -> None:
    """Show the current frame again after switching between track and tracing."""
    revisions.mark_changed()
    play(scene)
    redraw_viewports()


def known_stale_reasons(scene: Scene) -> tuple[str, ...] | None:
    """The changes since the bake found by the last comparison; None before the first one.

    For draw callbacks: after an edit, scene and track are compared after the redraw, with pauses between comparisons.
    """
    known = _compared.get(scene.session_uid)
    if known is not None and known.stamp != storage.stamp(scene):
        known = None
    if known is None or known.version != revisions.edits():
        _to_compare.add(scene.session_uid)
        if not bpy.app.timers.is_registered(_compare_shown):
            rest = 0.0 if known is None else known.at + _REST * known.seconds - time.perf_counter()
            bpy.app.timers.register(_compare_shown, first_interval=max(rest, 0.05))
    return None if known is None else tuple(words_for(change) for change in known.changes)


def _compare_shown() -> None:
    """Compare the scenes whose panels wait for it with their tracks, and redraw."""
    for scene in bpy.data.scenes:
        if scene.session_uid in _to_compare:
            stale_reasons(scene)
    _to_compare.clear()
    redraw_sidebars()


def stale_reasons(scene: Scene) -> tuple[str, ...]:
    """Sentences about the changes since the bake; () without changes or without a track."""
    track = storage.track_of(scene)
    if track is None:
        return ()
    stamp, version, started = storage.stamp(scene), revisions.edits(), time.perf_counter()
    found = compare(scene, track)
    ended = time.perf_counter()
    _compared[scene.session_uid] = _Compared(stamp, version, ended, ended - started, found)
    return tuple(words_for(change) for change in found)


def compare(scene: Scene, track: HapticTrack) -> tuple[Change, ...]:
    """The differences between a scene and its baked track."""
    first, last = wanted_range(scene)
    found = changes(track.digest, digest_of(scene))
    if first < track.frame_start or last > track.frame_end:
        return (("range", first, last, track.frame_start, track.frame_end), *found)
    return found


def fitting_track(scene: Scene, start: int, end: int) -> HapticTrack | None:
    """The scene's baked track if it contains the frames and nothing has changed since the bake."""
    track = storage.track_of(scene)
    if track is None or start < track.frame_start or end > track.frame_end or compare(scene, track):
        return None
    return track


def wanted_range(scene: Scene) -> tuple[int, int]:
    """The frames to bake."""
    bake = scene.haptics.bake
    return (bake.frame_start, bake.frame_end) if bake.use_range else (scene.frame_start, scene.frame_end)


def forget() -> None:
    """Drop all state of tracks, because another file is loaded or the add-on is disabled."""
    storage.forget()
    _compared.clear()
    _to_compare.clear()
    if bpy.app.timers.is_registered(_compare_shown):
        bpy.app.timers.unregister(_compare_shown)


file_changed.subscribe(forget)
