"""Storage of a track, as bytes in a property of a text datablock of the scene. A text is saved with
the file, does not affect Blender's evaluation, and explains its content to a reader."""

from __future__ import annotations

import uuid
from typing import Any

import bpy
from bpy.types import Scene, Text

from .track import HapticTrack, TrackError, track_from_bytes

_DATA, _STAMP = "haptic_track", "haptic_track_stamp"

# By session id of the text: its stamp, and the track or the error.
_read: dict[int, tuple[str, HapticTrack | None, str]] = {}


def keep(scene: Scene, track: HapticTrack) -> None:
    """Store a track with the scene, in place of an earlier one."""
    text = scene.haptics.bake.track
    if text is None or not text.is_editable or _is_kept_elsewhere(text, scene):
        text = bpy.data.texts.new(f"Haptic Track {scene.name}")
        scene.haptics.bake.track = text
    text.use_fake_user = False
    text[_DATA] = track.to_bytes()
    text[_STAMP] = uuid.uuid4().hex
    text.clear()
    text.write(_summary(scene, track))
    _read[text.session_uid] = text[_STAMP], track, ""


def drop(scene: Scene) -> None:
    """Remove the scene's track; if it was kept as a take, that take as well."""
    bake = scene.haptics.bake
    text, bake.track = bake.track, None
    for index in [k for k, take in enumerate(bake.takes) if take.track == text]:
        bake.takes.remove(index)
    if text is not None and text.is_editable and text.users == 0:
        bpy.data.texts.remove(text)


def track_of(scene: Scene) -> HapticTrack | None:
    """The scene's track; None if there is none, or none that can be read."""
    return track_in(scene.haptics.bake.track)


def played_track(scene: Scene) -> HapticTrack | None:
    """The track that the frames of a scene come from; None while they are traced."""
    bake = scene.haptics.bake
    return track_in(bake.track) if bake.use_track else None


def track_in(text: Text | None) -> HapticTrack | None:
    """The track in a text; None if there is none, or none that can be read."""
    return _kept(text)[0]


def trouble(scene: Scene) -> str:
    """Why the scene's track can't be read; "" where it can, or where there is none."""
    return _kept(scene.haptics.bake.track)[1]


def stamp(scene: Scene) -> str:
    """Identifier of the scene's bake, different for each; "" if there is none."""
    return stamp_of(scene.haptics.bake.track)


def stamp_of(text: Text | None) -> str:
    """Identifier of the bake in a text."""
    value = None if text is None else text.get(_STAMP)
    return value if isinstance(value, str) else ""


def forget() -> None:
    """Drop all cached tracks."""
    _read.clear()


def _kept(text: Text | None) -> tuple[HapticTrack | None, str]:
    if text is None:
        return None, ""
    known = _read.get(text.session_uid)
    mark = stamp_of(text)
    if known is None or known[0] != mark:
        known = (mark, *_decoded(text.get(_DATA)))
        _read[text.session_uid] = known
    return known[1], known[2]


def _decoded(data: Any) -> tuple[HapticTrack | None, str]:
    if not isinstance(data, bytes):
        return None, "The text that should hold the haptic track does not: bake again"
    try:
        return track_from_bytes(data), ""
    except TrackError as error:
        message = str(error)
        return None, message[:1].upper() + message[1:]


def _is_kept_elsewhere(text: Text, scene: Scene) -> bool:
    """Whether another scene has the bake in a text, or any scene as a take."""
    bakes = [(other, other.haptics.bake) for other in bpy.data.scenes]
    return any(
        (other != scene and bake.track == text) or any(take.track == text for take in bake.takes)
        for other, bake in bakes
    )


def _summary(scene: Scene, track: HapticTrack) -> str:
    lines = [
        f"Haptic track of scene {scene.name}: frames {track.frame_start} to {track.frame_end}, "
        f"{track.duration:.2f} s.",
        f"{track.samples.shape[1]} samples a listener at {track.sample_rate} Hz, "
        f"{len(track.sources)} sources.",
        "The track itself is a property of this text; baking again replaces it.",
        "",
        "Listeners:",
        *(f"  {item.name}  {item.body_part}".rstrip() for item in track.listeners),
    ]
    return "\n".join(lines) + "\n"
