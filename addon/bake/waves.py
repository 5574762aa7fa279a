"""The waves of a scene's baked track, computed on the worker thread."""

from __future__ import annotations

import numpy as np
from bpy.types import Scene

from ...core.render.waves import Waves
from ..changes.events import file_changed
from ..session.derived import Background
from . import storage
from .track import HapticTrack

_kept: dict[int, Background[Waves | None]] = {}  # by session id of the scene


def waves_of(scene: Scene) -> Waves | None:
    """The waves of the track that is played, without waiting; None if there are none yet."""
    track = storage.played_track(scene)
    if track is None:
        return None
    mark = storage.stamp(scene)
    latest = _kept.setdefault(scene.session_uid, Background()).latest(
        mark, lambda before: computed(track)
    )
    return latest.value if latest is not None and latest.is_current else None


def computed(track: HapticTrack) -> Waves | None:
    """The waves of a track; None if it has no samples."""
    if not track.samples.size:
        return None
    origin = (
        track.frame_start
        + (track.first_sample / track.sample_rate - track.start) / track.frame_duration
    )
    names = [item.name for item in track.listeners]
    waves = Waves(
        names, origin, track.sample_rate * track.frame_duration, track.samples, filled=True
    )
    waves.find_thresholds(track.sample_rate)
    numbers, rows = np.unique(track.row_source, return_index=True)
    begun = [
        (track.sources[number].onset, row)
        for number, row in zip(numbers, rows, strict=True)
        if track.sources[number].second_object
    ]
    onset = np.array([time for time, _ in begun])
    gains = track.row_gain[np.array([row for _, row in begun], dtype=np.int64)].astype(np.float64)
    waves.add_impacts(track.frame_start + (onset - track.start) / track.frame_duration, gains)
    return waves


file_changed.subscribe(_kept.clear)
