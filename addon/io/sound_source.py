"""Conversion of a sound in Blender to vibration, which is stored with the source."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Generator, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from bpy.types import Object, Scene

from ...core.arrays import FloatArray
from ...core.signals import Automation, Loop
from ...core.signals.felt_sound import Feel, amplitudes, felt_onsets, vibration
from ...core.signals.sound import Clip, Heard, block_count, heard, mixed
from ..blender import compatibility
from ..blender.single_precision import shortest
from ..blender.time import frame_seconds, seconds_of, stretching
from ..blender.words import TranslatedError, ui_text
from ..properties.sound import device_profiles, sound_path
from ..scene_reader.kept_signal import text_of_signal

WAVE_COLUMNS = 256
"""Values of each of the two waves that a panel draws."""
_KNOWN_SOUNDS = 8

_known: dict[bytes, Heard] = {}
"""Analyses of the last sounds, by the digest of their samples: 2 MB for ten minutes."""


class DecodedSound:
    """A sound of any format that Blender reads, decoded in parts. ``rate`` in hertz, ``count``
    samples. Raises ValueError."""

    def __init__(self, path: Path, name: str = "", folder: Any = None) -> None:
        """name: of the sound for the user, that of the file by default. folder: is kept as long as
        the sound."""
        try:
            import aud
        except ImportError:
            raise TranslatedError("this Blender is built without audio") from None
        self._sound = aud.Sound.file(str(path))
        self._folder = folder
        self._name = name or path.name
        self._error = aud.error
        try:
            self.rate, self.count = float(self._sound.specs[0]), int(self._sound.length)
        except aud.error as error:
            raise ValueError(f"{self._name}: {error}") from None

    def read(self, first: int, last: int) -> FloatArray:
        """See `core.signals.sound.DecodedSound`."""
        try:
            part = self._sound.limit((first + 0.5) / self.rate, (last + 0.5) / self.rate).data()
        except self._error as error:
            raise ValueError(f"{self._name}: {error}") from None
        return np.pad(part.astype(np.float64), ((0, max(last - first - len(part), 0)), (0, 0)))[
            : last - first
        ]


class Conversion:
    """Converts an object's sound to vibration, in steps. Raises OSError or ValueError if there is
    no sound."""

    def __init__(self, scene: Scene, obj: Object) -> None:
        sound = obj.haptics.source.sound
        self._name = obj.name
        self._feel = _feel(sound)
        self._loops = sound.origin == "FILE" and sound.loop
        self._clips = tuple(_CLIPS[sound.origin](scene, sound))
        self._taken = taken(scene, sound)
        self.step_count = sum(block_count(clip.end) for clip in self._clips) + block_count(
            max(clip.end for clip in self._clips)
        )

    def steps(self) -> Iterator[None]:
        """Analyse the sound, then store its vibration with the object; a fault of the sound is also
        stored, and raised."""
        try:
            yield from self._steps()
        except (OSError, ValueError) as error:
            fault = bpy.data.objects[self._name].haptics.source.sound.fault = ui_text(str(error))
            raise ValueError(fault) from None
        bpy.ops.ed.undo_push(message="Convert Sound")

    def _steps(self) -> Generator[None, None, None]:
        samples = yield from mixed(self._clips)
        key = hashlib.blake2b(samples.tobytes()).digest()
        found = _known.pop(key, None) or (yield from heard(samples))
        _known[key] = found
        while len(_known) > _KNOWN_SOUNDS:
            del _known[next(iter(_known))]
        signal = vibration(found, self._feel)
        sound = bpy.data.objects[self._name].haptics.source.sound
        sound.waves = _waves(found, self._feel)
        sound.taken = self._taken
        sound.is_edited = False
        sound.fault = ""
        sound.kept = text_of_signal(Loop(signal) if self._loops else signal)


def taken(scene: Scene, sound: Any) -> str:
    """A checksum of what a conversion takes from the strips of a scene or from a speaker: sounds,
    times and volumes; "" of a file."""
    items: list[Any] = []
    if sound.origin == "SEQUENCER":
        for strip in _strips(scene, sound):
            ends = *compatibility.strip_ends(strip), compatibility.strip_content_start(strip)
            path = strip.path_from_id("volume")
            items.append((strip.sound.filepath, ends, _fade(scene, path) or strip.volume))
    elif sound.origin == "SPEAKER" and _plays(sound.speaker):
        data = sound.speaker.data
        volume = _fade(data, "volume") or data.volume
        items += (data.sound.filepath, data.pitch, volume, _starts(scene, sound.speaker))
    else:
        return ""
    times = scene.frame_start, frame_seconds(scene), stretching(scene)
    return hashlib.blake2b(repr((times, items)).encode(), digest_size=16).hexdigest()


def _feel(sound: Any) -> Feel:
    frequency = shortest(sound.frequency)
    if sound.carrier == "DEVICE":
        known = device_profiles().get(sound.device)
        if known is None:
            raise TranslatedError("there is no device profile '{}'", sound.device)
        frequency = known.best_frequency
    return Feel(frequency, sound.carrier == "PITCH", gain=shortest(sound.gain))


def _waves(found: Heard, feel: Feel) -> str:
    """The largest amplitude of the sound and of its vibration in each column of a picture as
    hexadecimals, 255 being the larger of them."""
    felt = amplitudes(found, feel)
    times, bursts = felt_onsets(found, feel)
    np.maximum.at(
        felt,
        np.minimum(np.rint(times * len(felt) / found.seconds).astype(np.intp), len(felt) - 1),
        bursts,
    )
    borders = np.linspace(0, len(felt), WAVE_COLUMNS, endpoint=False).astype(np.intp)
    rows = np.array([np.maximum.reduceat(values, borders) for values in (found.levels, felt)])
    return (rows * (255 / rows.max())).astype(np.uint8).tobytes().hex()


def _of_file(scene: Scene, sound: Any) -> Iterator[Clip]:
    if not sound.filepath:
        raise TranslatedError("choose a file first")
    yield Clip(DecodedSound(sound_path(sound.id_data, sound.filepath)))


def _of_speaker(scene: Scene, sound: Any) -> Iterator[Clip]:
    speaker = sound.speaker
    if not _plays(speaker):
        raise TranslatedError("choose a speaker first that has a sound and is not muted")
    data = speaker.data
    for start in _starts(scene, speaker):
        clip = Clip(_decoded(data.sound), seconds_of(scene, start), speed=shortest(data.pitch))
        yield replace(clip, volume=_volume(data, "volume", data.volume, scene, clip.end))


def _plays(speaker: Object | None) -> bool:
    """Whether an object is a speaker that has a sound and is not muted."""
    data: Any = None if speaker is None or speaker.type != "SPEAKER" else speaker.data
    return data is not None and data.sound is not None and not data.muted


def _starts(scene: Scene, speaker: Object) -> list[float]:
    """The frames at which a speaker begins to play."""
    animation = speaker.animation_data
    tracks = [
        track for track in (animation.nla_tracks if animation is not None else ()) if not track.mute
    ]
    starts = [
        strip.frame_start
        for track in tracks
        for strip in track.strips
        if strip.type == "SOUND" and not strip.mute
    ]
    return starts or [scene.frame_start]


def _of_sequencer(scene: Scene, sound: Any) -> Iterator[Clip]:
    chosen = _strips(scene, sound)
    if not chosen:
        raise TranslatedError("there is no sound strip '{}' that is not muted", sound.strip or "*")
    for strip in chosen:
        if len(getattr(strip, "retiming_keys", ())):
            raise TranslatedError(
                "the strip '{}' is retimed: render the audio to a file and choose that", strip.name
            )
        first, last = compatibility.strip_ends(strip)
        begin = compatibility.strip_content_start(strip)
        second = frame_seconds(scene)
        start = max(first, begin)
        volume = _volume(
            scene, strip.path_from_id("volume"), strip.volume, scene, seconds_of(scene, last)
        )
        yield Clip(
            _decoded(strip.sound),
            seconds_of(scene, start),
            (start - begin) * second,
            (last - start) * second,
            volume=volume,
        )


def _strips(scene: Scene, sound: Any) -> list[Any]:
    """The chosen sound strips of a scene that are not muted."""
    strips = (
        compatibility.strips_of(scene.sequence_editor) if scene.sequence_editor is not None else ()
    )
    return [
        strip
        for strip in strips
        if strip.type == "SOUND"
        and strip.sound is not None
        and not strip.mute
        and sound.strip in ("", strip.name)
    ]


_CLIPS = {"FILE": _of_file, "SPEAKER": _of_speaker, "SEQUENCER": _of_sequencer}


def _decoded(sound: Any) -> DecodedSound:
    if sound.packed_file is None:
        return DecodedSound(sound_path(sound, sound.filepath))
    folder = tempfile.TemporaryDirectory()
    path = Path(folder.name) / "sound"
    path.write_bytes(sound.packed_file.data)
    return DecodedSound(path, bpy.path.basename(sound.filepath) or sound.name, folder)


def _volume(owner: Any, path: str, value: float, scene: Scene, end: float) -> float | Automation:
    """A volume, over the scene's time if it is animated.

    Args:
        owner: datablock that has it.
        path: its data path.
        value: its current value.
        scene: gives the frames.
        end: up to which it is needed [s].
    """
    curve = _curve(owner, path)
    if curve is None:
        return shortest(value)
    times = np.arange(max(end, 0.0) // frame_seconds(scene) + 2) * frame_seconds(scene)
    frames = (scene.frame_start + np.arange(len(times))) / stretching(scene)
    return Automation(times, [max(curve.evaluate(frame), 0.0) for frame in frames.tolist()])


def _fade(owner: Any, path: str) -> list[tuple[float, ...]]:
    """The keyframes of a volume, none where it is not animated."""
    curve = _curve(owner, path)
    return [] if curve is None else [tuple(key.co) for key in curve.keyframe_points]


def _curve(owner: Any, path: str) -> Any:
    """The F-curve of a property, None where it is not animated."""
    curves = compatibility.fcurves_of(owner)
    return next((curve for curve in curves if curve.data_path == path and not curve.mute), None)
