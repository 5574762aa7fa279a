"""``haptic-tracing play FILE``: a haptic file, or what a scene's listeners feel, on the connected
devices."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from itertools import cycle
from pathlib import Path

import numpy as np
from tqdm import tqdm

from ..core.arrays import FloatArray
from ..core.formats import registry
from ..core.formats.tracks.listener_tracks import Tracks
from ..core.formats.tracks.wav import at_rate
from ..core.message import sentence
from ..core.run_time import load
from . import answer, say
from .convert import given, is_scene, tracks_of
from .exported_scene import rendered
from .keyboard import pressed_keys
from .serve.stage import DeviceStage
from .standard_streams import leave_in_order_when_ended

RATE = 8000
"""Sample rate of what is sent to devices [Hz]."""
_BLOCK = 0.02
_PATIENCE = 3.0


def run(args: argparse.Namespace) -> int:
    """Read the file, open the devices, play. Exit code 0."""
    leave_in_order_when_ended()
    tracks = _tracks(given(args.file, args.read_as), args.seconds)
    samples, parts = _at_body_parts(at_rate(tracks, RATE))
    stage = DeviceStage.of(args.device)
    try:
        for output in stage.outputs.values():
            output.wait_until_open(_PATIENCE)
        say(f"plays on {output.profile.title}" for output in stage.outputs.values())
        say(f"{loss.listener}: {sentence(loss.message)}" for loss in stage.mapping(parts).losses)
        with pressed_keys() as key:
            played = _play(samples, lambda block: stage.send(parts, block), stage.stop, key)
    finally:
        stage.close()
    written = {name: output.status.written for name, output in stage.outputs.items()}
    answer(args, {"seconds": played, "reports": written})
    return 0


def _tracks(path: Path, seconds: float) -> Tracks:
    """What a file holds, a scene's rendered if it has none. Raises ValueError."""
    if not is_scene(path):
        try:
            reading = registry.read(path)
            say(f"{path.name}: {loss}" for loss in reading.losses)
            return tracks_of(reading)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None
    scene = load(path)
    return rendered(scene, seconds, RATE).need_tracks()


def _at_body_parts(tracks: Tracks) -> tuple[FloatArray, dict[str, str]]:
    """The samples (listeners, n), and the body part of each listener by its name. What has none is
    felt in the hands: one channel in both, several in the left and the right one in turn."""
    samples = np.asarray(tracks.samples, dtype=np.float64)
    parts = {item.name: item.body_part for item in tracks.listeners}
    nowhere = [name for name, part in parts.items() if not part]
    if len(parts) == len(nowhere) == 1:
        return np.repeat(samples, 2, axis=0), {"left": "hand.L", "right": "hand.R"}
    hands = cycle(("hand.L", "hand.R"))
    return samples, {**parts, **{name: next(hands) for name in nowhere}}


def _play(
    samples: FloatArray,
    send: Callable[[FloatArray], None],
    silence: Callable[[], None],
    key: Callable[[], str],
) -> float:
    """Send the samples (listeners, n) block by block as time passes; the seconds that were played.
    Space pauses, q stops."""
    at, size, count, paused = 0, round(_BLOCK * RATE), samples.shape[1], False
    due = time.monotonic()
    with tqdm(
        total=round(count / RATE, 2),
        unit="s",
        disable=None,
        bar_format="{n:.1f} of {total:.1f} s |{bar}| space pauses, q stops",
    ) as bar:
        while at < count and (pressed := key()) != "q":
            if pressed == " ":
                paused = not paused
                silence()
            if not paused:
                send(samples[:, at : at + size])
                at += size
                bar.update(_BLOCK)
            now = time.monotonic()
            due = now + _BLOCK if paused else max(due + _BLOCK, now)
            time.sleep(due - now)
    return float(min(at, count) / RATE)
