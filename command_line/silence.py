"""Sentences about listeners whose rendered tracks are silent."""

from __future__ import annotations

from ..core.diagnosis.silence import reasons
from ..core.formats.tracks.listener_tracks import Tracks
from ..core.message import sentence
from ..core.render.frame_result import FrameResult
from ..core.scene.values import Settings

MOST_LISTENERS = 10


def silent_listeners(tracks: Tracks, last: FrameResult, settings: Settings) -> list[str]:
    """A sentence for each listener whose whole track is 0, with the reason in the ``last``
    frame."""
    silent = [row for row, samples in enumerate(tracks.samples) if not samples.any()]
    said = []
    for row in silent[:MOST_LISTENERS]:
        why = reasons(last, settings, row, recent=tracks.samples[row, -2:].astype("f8")) or (
            "no reason was found",
        )
        words = "; ".join(one if isinstance(one, str) else sentence(one) for one in why)
        said.append(f"'{tracks.listeners[row].name}' feels nothing: {words}")
    if len(silent) > MOST_LISTENERS:
        said.append(f"{len(silent) - MOST_LISTENERS} more listeners feel nothing")
    return said
