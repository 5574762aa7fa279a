"""Takes: bakes stored under a name, one of which is played, and their differences."""

from __future__ import annotations

import numpy as np
from bpy.types import Scene

from ...core.frozen import frozen
from ...core.render.integers import FULL_SCALE
from ...core.render.levels import vibration_rms
from ..changes.events import file_changed
from ..changes.redraw import redraw_viewports
from ..session.derived import Background, Latest
from . import storage
from .track import HapticTrack


@frozen
class Difference:
    """The RMS levels [dB of full scale] of a listener over the whole of two takes, minus infinity
    for silence; NaN for a take without the listener."""

    listener: str
    here: float
    there: float


_kept: dict[int, Background[tuple[Difference, ...]]] = {}  # by session id of the scene


def is_take(scene: Scene) -> bool:
    """Whether the scene's bake is a take."""
    bake = scene.haptics.bake
    return any(take.track == bake.track for take in bake.takes)


def keep(scene: Scene) -> None:
    """Store the scene's bake as a take, unless it is one already."""
    bake = scene.haptics.bake
    if bake.track is not None and not is_take(scene):
        take = bake.takes.add()
        names = {other.name for other in bake.takes}
        take.name = next(
            name
            for name in (f"Take {number}" for number in range(1, len(names) + 2))
            if name not in names
        )
        take.track = bake.track


def play(scene: Scene, index: int) -> None:
    """Play a take whenever the timeline plays; the one played before is kept for comparison."""
    keep(scene)
    bake = scene.haptics.bake
    if bake.track != bake.takes[index].track:
        bake.compared = bake.track
        bake.track = bake.takes[index].track
    bake.use_track = True
    redraw_viewports()


def differences(scene: Scene) -> Latest[tuple[Difference, ...]] | None:
    """The differences between the current take and the one played before, without waiting; None
    before they are known."""
    texts = scene.haptics.bake.track, scene.haptics.bake.compared
    here, there = (storage.track_in(text) for text in texts)
    if here is None or there is None:
        return None
    key = tuple(storage.stamp_of(text) for text in texts)
    return _kept.setdefault(scene.session_uid, Background()).latest(
        key, lambda before: _differences(here, there)
    )


def _differences(here: HapticTrack, there: HapticTrack) -> tuple[Difference, ...]:
    levels = [
        dict(zip((item.name for item in track.listeners), _levels(track), strict=True))
        for track in (here, there)
    ]
    return tuple(
        Difference(name, *(known.get(name, float("nan")) for known in levels))
        for name in {**levels[0], **levels[1]}
    )


def _levels(track: HapticTrack) -> list[float]:
    with np.errstate(divide="ignore", invalid="ignore"):
        return [
            20 * float(np.log10(vibration_rms(row, track.sample_rate) / FULL_SCALE))
            for row in track.samples
        ]


file_changed.subscribe(_kept.clear)
