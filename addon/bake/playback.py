"""Playback of a baked scene, whose frames come from the track while the timeline plays, and
comparison of the track with the scene."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import bpy
import numpy as np
from bpy.types import Scene

from ...core.render.frame_result import FrameResult
from ...core.render.history import SECONDS
from ...core.scene.values import SourceKind
from ..blender.time import is_playing
from ..changes import revisions
from ..changes.events import file_changed
from ..changes.redraw import redraw_sidebars
from ..scene_reader.digest import Change, changes, digest_of, words_for
from ..scene_reader.objects import calibrated
from ..session import session, sessions
from ..session.derived import Derived
from ..session.sessions import Traced
from ..session.timeline import simulation_start
from . import storage
from .track import HapticTrack

_ALIKE, _LEAST = 0.1, 1e-4
"""Difference in decibels up to which arriving amplitudes are alike, and the amplitude above which
they are compared."""
_REST = 20.0  # pause after a comparison of scene and track, as a multiple of its duration


@dataclass(slots=True)
class _Compared:
    """When a scene was last compared with its track, which is known by its stamp, how long that
    took, and what had changed."""

    stamp: str
    version: int
    at: float
    seconds: float
    changes: tuple[Change, ...]


_compared: dict[int, _Compared] = {}  # by session id of the scene
_to_compare: set[int] = set()  # session ids of scenes whose panel waits for a comparison


def plays(scene: Scene) -> bool:
    """Whether the current frame comes from the track: while the timeline plays, in the mode that
    was baked. While it stands, frames are traced as the scene is now."""
    track = storage.played_track(scene) if is_playing() else None
    if track is None or track.mode not in {"", scene.haptics.mode}:
        return False
    return track.frame_start <= scene.frame_current <= track.frame_end


def play(scene: Scene) -> bool:
    """Show the current frame from the track if it `plays`."""
    started = time.perf_counter()
    track = storage.played_track(scene) if plays(scene) else None
    result = None if track is None else track.result(scene.frame_current)
    if track is None or result is None:
        return False
    result = replace(
        result,
        listeners=tuple(map(calibrated, result.listeners)),
        milliseconds={"read_track": 1000 * (time.perf_counter() - started)},
    )
    number = scene.frame_current
    session.show(scene, result, track.samples_until(number, SECONDS), track.paths(number))
    return True


def impacts_of(scene: Scene) -> str:
    """The impacts that the played bake has in the current frame, as text; "" if it has none, or
    while the timeline plays."""
    track = None if is_playing() else storage.played_track(scene)
    return "" if track is None else track.impacts.get(scene.frame_current, "")


def is_from_track(result: FrameResult) -> bool:
    """Whether a result was read from a track."""
    return "read_track" in result.milliseconds


def known_stale_reasons(scene: Scene) -> tuple[str, ...] | None:
    """The changes since the bake found by the last comparison, and whether the shown frame is felt
    otherwise than it was baked; None before the first comparison.

    For draw callbacks: after an edit, scene and track are compared after the redraw, with pauses
    between comparisons.
    """
    known = _compared.get(scene.session_uid)
    if known is not None and known.stamp != storage.stamp(scene):
        known = None
    if known is None or known.version != revisions.edits():
        _to_compare.add(scene.session_uid)
        if not bpy.app.timers.is_registered(_compare_shown):
            rest = 0.0 if known is None else known.at + _REST * known.seconds - time.perf_counter()
            bpy.app.timers.register(_compare_shown, first_interval=max(rest, 0.05))
    if known is None:
        return None
    frame = scene.frame_current
    track = storage.track_of(scene)
    differs = (
        None
        if track is None or simulation_start(scene, frame) < frame
        else _DIFFERS.latest(scene, track)
    )
    felt: tuple[Change, ...] = (
        (("felt", frame),) if differs is not None and differs.is_current and differs.value else ()
    )
    return tuple(words_for(change) for change in (*known.changes, *felt))


def _differs(traced: Traced, track: HapticTrack, before: bool | None = None) -> bool:
    """Whether the sources that play all the time arrive with another amplitude than was baked in
    that frame: by more than `_ALIKE`."""
    baked = track.result(traced.result.number)
    if baked is None or traced.reading is None:
        return False
    lasting = {
        source.name
        for source in traced.reading.sources
        if source.triggers is None and source.kind is SourceKind.PERSISTENT
    }
    now, then = (
        {pair: value for pair, value in _arriving(result) if pair[0] in lasting}
        for result in (traced.result, baked)
    )
    return now.keys() != then.keys() or any(
        abs(20 * math.log10(value / then[pair])) > _ALIKE for pair, value in now.items()
    )


def _arriving(result: FrameResult) -> Iterator[tuple[tuple[str, str], float]]:
    """The amplitudes that arrive in a frame and may be felt, each with the names of its source and
    its listener."""
    for row, column in np.argwhere(result.amplitudes > _LEAST).tolist():
        yield (
            (result.sources[row].name, result.listeners[column].name),
            float(result.amplitudes[row, column]),
        )


_DIFFERS: Derived[HapticTrack, bool] = Derived(_differs)


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
    stamp = storage.stamp(scene)
    version = revisions.edits()
    started = time.perf_counter()
    found = compare(scene, track)
    ended = time.perf_counter()
    _compared[scene.session_uid] = _Compared(stamp, version, ended, ended - started, found)
    return tuple(words_for(change) for change in found)


def compare(scene: Scene, track: HapticTrack) -> tuple[Change, ...]:
    """The differences between a scene and its baked track."""
    first, last = scene.frame_start, scene.frame_end
    found = changes(track.digest, digest_of(scene))
    if first < track.frame_start or last > track.frame_end:
        return (("range", first, last, track.frame_start, track.frame_end), *found)
    return found


def fitting_track(scene: Scene, start: int, end: int) -> HapticTrack | None:
    """The scene's baked track if it contains the frames and nothing has changed since the bake."""
    track = storage.track_of(scene)
    traced = sessions.shown(scene)
    if track is None or start < track.frame_start or end > track.frame_end or compare(scene, track):
        return None
    return None if traced is not None and _differs(traced, track) else track


def forget() -> None:
    """Drop all state of tracks, because another file is loaded or the add-on is disabled."""
    storage.forget()
    _compared.clear()
    _to_compare.clear()
    if bpy.app.timers.is_registered(_compare_shown):
        bpy.app.timers.unregister(_compare_shown)


file_changed.subscribe(forget)
