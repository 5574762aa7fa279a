"""The waves of a scene's baked track, computed on the worker thread."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from bpy.types import Scene

from ...addon.bake import storage
from ...addon.bake.track import HapticTrack
from ...addon.changes.events import file_changed
from ...addon.scene_reader.objects import calibrated
from ...addon.session.derived import Background
from ...core.scene.values import Listener
from .waves import Waves, row_name

_kept: dict[int, Background[Waves | None]] = {}  # by session id of the scene


def waves_of(scene: Scene) -> Waves | None:
    """The waves of the track that is played, without waiting; None if there are none yet."""
    track = storage.played_track(scene)
    if track is None:
        return None
    listeners = tuple(calibrated(Listener(item.name, item.name)) for item in track.listeners)
    latest = _kept.setdefault(scene.session_uid, Background()).latest(
        (storage.stamp(scene), listeners), lambda before: computed(track, listeners)
    )
    return latest.value if latest is not None and latest.is_current else None


def computed(track: HapticTrack, listeners: Sequence[Listener]) -> Waves | None:
    """The waves of a track with the thresholds of its ``listeners``; None if it has no samples."""
    if not track.samples.size:
        return None
    origin = (
        track.frame_start
        + (track.first_sample / track.sample_rate - track.start) / track.frame_duration
    )
    names = [item.name for item in listeners]
    waves = Waves(
        names, origin, track.sample_rate * track.frame_duration, track.samples, filled=True
    )
    waves.find_levels(track.sample_rate, listeners)
    for frame in range(track.frame_count):
        first, last = track.rows[frame : frame + 2].tolist()
        sounding = (track.sources[number] for number in track.row_source[first:last])
        named = (row_name(item.name, item.second_object, item.onset) for item in sounding)
        amplitudes = dict(zip(named, track.row_amplitude[first:last].tolist(), strict=True))
        at = track.frame_start + frame - 1 - math.floor(origin)
        waves.write_sources(slice(at, at + 1), amplitudes)
    numbers, rows = np.unique(track.row_source, return_index=True)
    begun = [track.sources[number] for number in numbers]
    struck = np.array([bool(item.second_object) for item in begun], dtype=np.bool_)
    onset = np.array([item.onset for item in begun])[struck]
    gains = track.row_gain[rows[struck]].astype(np.float64)
    waves.add_impacts(track.frame_start + (onset - track.start) / track.frame_duration, gains)
    return waves


file_changed.subscribe(_kept.clear)
