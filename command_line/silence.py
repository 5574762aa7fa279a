"""Sentences about listeners whose rendered tracks are silent."""

from __future__ import annotations

from ..core.diagnosis.silence import silence_of
from ..core.formats.tracks.listener_tracks import Tracks
from ..core.render.frame_result import FrameResult
from ..core.scene.values import Settings

MOST_LISTENERS = 10


def silent_listeners(tracks: Tracks, last: FrameResult, settings: Settings) -> list[str]:
    """A sentence for each listener whose whole track is 0, with the reason in the ``last``
    frame."""
    silent = [row for row, samples in enumerate(tracks.samples) if not samples.any()]
    said = [
        silence_of(last, settings, row, tracks.samples[row, -2:].astype("f8"))
        for row in silent[:MOST_LISTENERS]
    ]
    if len(silent) > MOST_LISTENERS:
        said.append(f"{len(silent) - MOST_LISTENERS} more listeners feel nothing")
    return said
