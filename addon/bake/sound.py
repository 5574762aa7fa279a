"""A track as a sound strip, packed into the file: the left side of the body on the left channel,
the right side on the right."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from bpy.types import Scene

from ...core.formats.tracks.listener_tracks import CHUNK, ListenerTrack, Tracks
from ...core.formats.tracks.wav import write_wav
from ...core.render.waves import FULL_SCALE
from ...core.scene.body import stereo_gains
from ..blender import compatibility
from .track import HapticTrack

NAME = "Haptics"
_HEADROOM = 0.9


def add_strip(scene: Scene, track: HapticTrack) -> Any:
    """Add the sound strip on the lowest free channel, in place of an earlier one. Returns the
    strip.

    Raises ValueError if Blender was built without sound.
    """
    channel = remove_strip(scene)
    editor = scene.sequence_editor or scene.sequence_editor_create()
    strips = compatibility.strips_of(editor)
    first = track.frame_start + round(
        (track.first_sample / track.sample_rate - track.start) / track.frame_duration
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{NAME}.wav"
        write_stereo(track, path)
        try:
            strip = strips.new_sound(
                NAME, str(path), channel or _free_channel(strips, track), first
            )
        except RuntimeError as error:
            raise ValueError(str(error).strip().removeprefix("Error: ")) from None
        strip.sound.pack()
    sound = strip.sound
    sound.name = f"{NAME} {scene.name}"
    sound.filepath = f"//{NAME}.wav"  # the name to unpack it to
    scene.haptics.bake.sound = sound
    return strip


def remove_strip(scene: Scene) -> int:
    """Remove the strip of an earlier bake, and its sound if nothing else uses it. Returns the
    strip's channel, or 0."""
    sound = scene.haptics.bake.sound
    channel = 0
    if sound is None:
        return channel
    if scene.sequence_editor is not None:
        strips = compatibility.strips_of(scene.sequence_editor)
        for strip in [strip for strip in strips if strip.type == "SOUND" and strip.sound == sound]:
            channel = strip.channel
            strips.remove(strip)
    scene.haptics.bake.sound = None
    if sound.users == 0:
        bpy.data.sounds.remove(sound)
    return channel


def write_stereo(track: HapticTrack, path: Path) -> None:
    """Write a 16-bit WAV file: each channel is the sum of the listeners of its side, with those in
    the middle on both, scaled down if it would clip."""
    sides = np.array(
        [stereo_gains(item.body_part) for item in track.listeners], dtype=np.float64
    ).reshape(-1, 2)
    weights = sides / np.sqrt(np.maximum((sides**2).sum(axis=0), 1.0)) / FULL_SCALE
    mix = np.zeros((2, max(track.samples.shape[1], 1)), dtype=np.float32)
    for first in range(0, track.samples.shape[1], CHUNK):
        piece = track.samples[:, first : first + CHUNK]
        mix[:, first : first + CHUNK] = np.einsum("lc,ln->cn", weights, piece)
    mix *= _HEADROOM / max(float(np.abs(mix).max()), _HEADROOM)
    channels = ListenerTrack("left"), ListenerTrack("right")
    write_wav(Tracks(channels, track.sample_rate, mix), path)


def _free_channel(strips: Any, track: HapticTrack) -> int:
    ends = ((strip.channel, *compatibility.strip_ends(strip)) for strip in strips)
    taken = {
        channel
        for channel, start, end in ends
        if start <= track.frame_end and end >= track.frame_start
    }
    return next(channel for channel in range(1, 129) if channel not in taken or channel == 128)
