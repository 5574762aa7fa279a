"""The export of a haptic scene: what its file holds, and its tracks, rendered if it has none."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace

from ..core.diagnosis.doubts import doubts
from ..core.formats.export import Export
from ..core.formats.tracks.track_recorder import TrackRecorder
from ..core.run_time import Scene, load
from . import say
from .silence import silent_listeners
from .standard_streams import DASH, from_input

LONGEST = 3600.0
"""Seconds."""
_SECONDS, _SAMPLE_RATE = 10.0, 8000


def exports(args: argparse.Namespace, formats: Sequence[str]) -> Iterator[Export]:
    """The scene; with its tracks, unless it is itself the only thing that is written."""
    seconds = _SECONDS if args.seconds is None else args.seconds
    if not 0 < seconds <= LONGEST:
        raise ValueError(f"--seconds: must be above 0 and at most {LONGEST:g}, not {seconds:g}")
    (path,) = args.files
    scene = load(from_input(".json") if path == DASH else path)
    say(f"{path}: {words}" for words in doubts(scene.content))
    rate = _SAMPLE_RATE if args.sample_rate is None else args.sample_rate
    yield scene.export if formats == ["scene"] else rendered(scene, seconds, rate)


def rendered(scene: Scene, seconds: float, sample_rate: int) -> Export:
    """What a scene's file holds, with its tracks, which are rendered if it has none. Prints why a
    listener feels nothing."""
    export = scene.export
    if export.tracks is not None or not scene.content.listeners:
        return export
    recorder, last = TrackRecorder(), None
    for last in scene.frames(seconds, sample_rate):
        recorder.add(last)
    tracks = recorder.tracks()
    if last is not None:
        settings = scene.content.settings
        say(f"{export.name}: {words}" for words in silent_listeners(tracks, last, settings))
    return replace(export, tracks=tracks)
