"""The parts of a haptic scene file that go beyond the scene at one moment: frames, tracks and devices."""

from __future__ import annotations

import base64
import binascii
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...scene.values import HapticScene, Pose
from ...signals.wav import wav_channels
from ..io.error import FormatError
from ..io.strict_json import read_bytes
from ..tracks.tracks import ListenerTrack, Tracks
from ..tracks.wav import MAX_RIFF, encoded
from .devices import ActuatorMapping, DeviceMapping
from .motion import unpacked
from .poses import Poses
from .recording import RecordedFrame, Recording, pair_of
from .scene_json import SceneReader, item_to_dict

MAX_INLINE = 192 * 2**20
"""Bytes of samples that may stand in a scene file itself."""

_TYPES = {"pcm16": "<i2", "float32": "<f4"}
_FULL_SCALE = {"pcm16": 32768.0, "float32": 1.0}


def frame_to_dict(frame: RecordedFrame) -> dict[str, Any]:
    """A frame as the file has it, without what did not change."""
    form: dict[str, Any] = {
        "frame": frame.number,
        "poses": {name: list(row) for name, row in frame.poses.items()},
        "properties": {name: list(pair) for name, pair in frame.properties.items()},
        "functions": {name: function.to_dict() for name, function in frame.functions.items()},
        "amplitudes": dict(frame.amplitudes),
        "source_positions": {name: [list(position) for position in positions] for name, positions in frame.source_positions.items()},
        "listener_positions": {name: list(position) for name, position in frame.listener_positions.items()},
        "gains": dict(frame.gains),
        "contacts": [item_to_dict(contact) for contact in frame.contacts],
        "parted": [list(pair) for pair in frame.parted],
        "sources": [item_to_dict(source) for source in frame.sources],
    }
    return {key: value for key, value in form.items() if key == "frame" or value}


def recording_from_dict(document: Mapping[str, Any], scene: HapticScene, file: str | Path) -> Recording | None:
    """The frames of a validated document, or None where it has none. Raises FormatError."""
    frames = document.get("frames", [])
    moving = unpacked(document.get("motions", []), {item.name for item in scene.objects}, file)
    if not frames:
        if moving:
            raise FormatError(file, "/frames", "is required where there are motions")
        return None
    if "frame_rate" not in document:
        raise FormatError(file, "/frame_rate", "is required where there are frames")
    reader = _FrameReader(scene, file)
    recorded = tuple(_moved(reader.frame(form, f"/frames/{i}", i), moving, f"/frames/{i}", file) for i, form in enumerate(frames))
    if moving:
        raise FormatError(file, "/motions", f"frame {min(moving)} is not among the frames")
    return Recording(float(document["frame_rate"]), document.get("frame_start", recorded[0].number), recorded)


def _moved(frame: RecordedFrame, moving: dict[int, Poses], place: str, file: str | Path) -> RecordedFrame:
    """A frame with the poses that motions have for it, which are taken out of ``moving``."""
    poses = moving.pop(frame.number, None)
    if poses is None:
        return frame
    for name in frame.poses:
        if name in poses:
            raise FormatError(file, f"{place}/poses/{_escaped(name)}", "a motion has a pose for this frame, too")
    return replace(frame, poses={**poses, **frame.poses} if frame.poses else poses)


class _FrameReader:
    """Reads frame after frame and keeps track of what there is, so that a reference to what is not there is noticed."""

    def __init__(self, scene: HapticScene, file: str | Path) -> None:
        self.file = file
        self.values = SceneReader(file)
        self.objects = {item.name for item in scene.objects}
        self.sources = {item.name: item for item in scene.sources}
        self.listeners = {item.name for item in scene.listeners}
        self.touching = {pair_of(contact) for contact in scene.contacts}
        self.last: int | None = None

    def frame(self, form: Mapping[str, Any], place: str, index: int) -> RecordedFrame:
        number = int(form["frame"])
        if self.last is not None and number <= self.last:
            raise FormatError(self.file, f"{place}/frame", f"must come after {self.last}, the frame before")
        self.last = number
        parts: tuple[str | int, ...] = ("frames", index)
        sources = tuple(self.values.source(source, (*parts, "sources", i)) for i, source in enumerate(form.get("sources", [])))
        for i, source in enumerate(sources):
            if source.name in self.sources:
                raise FormatError(self.file, f"{place}/sources/{i}/name", f"there is a source {source.name!r} already")
            self.sources[source.name] = source
            for key in ("object", "second_object"):
                if getattr(source, key) is not None:
                    self._known(getattr(source, key), self.objects, "object", f"{place}/sources/{i}/{key}")
        for key, known, kind in (
            ("poses", self.objects, "object"),
            ("properties", self.objects, "object"),
            ("functions", self.objects, "object"),
            ("amplitudes", self.sources, "source"),
            ("source_positions", self.sources, "source"),
            ("listener_positions", self.listeners, "listener"),
            ("gains", self.listeners, "listener"),
        ):
            for name in form.get(key, {}):
                self._known(name, known, kind, f"{place}/{key}/{_escaped(name)}")
        for name, row in form.get("poses", {}).items():
            self.values.made(Pose, {"position": row[:3], "rotation": row[3:]}, (*parts, "poses", name))
        contacts = tuple(self.values.contact(contact, (*parts, "contacts", i)) for i, contact in enumerate(form.get("contacts", [])))
        for i, contact in enumerate(contacts):
            for k, name in enumerate(contact.objects):
                self._known(name, self.objects, "object", f"{place}/contacts/{i}/objects/{k}")
        parted = tuple((min(pair), max(pair)) for pair in form.get("parted", []))
        for i, pair in enumerate(parted):
            if pair not in self.touching:
                raise FormatError(self.file, f"{place}/parted/{i}", f"{pair[0]!r} and {pair[1]!r} did not touch")
            self.touching.remove(pair)
        self.touching.update(pair_of(contact) for contact in contacts)
        return RecordedFrame(
            number=number,
            poses={name: tuple(row) for name, row in form.get("poses", {}).items()},
            properties={name: (row[0], row[1]) for name, row in form.get("properties", {}).items()},
            functions={
                name: self.values.function(function, (*parts, "functions", name)) for name, function in form.get("functions", {}).items()
            },
            amplitudes=form.get("amplitudes", {}),
            source_positions={
                name: tuple((x, y, z) for x, y, z in positions) for name, positions in form.get("source_positions", {}).items()
            },
            listener_positions={name: (x, y, z) for name, (x, y, z) in form.get("listener_positions", {}).items()},
            gains=form.get("gains", {}),
            contacts=contacts,
            parted=parted,
            sources=sources,
        )

    def _known(self, name: str, known: Any, kind: str, pointer: str) -> None:
        if name not in known:
            raise FormatError(self.file, pointer, f"there is no {kind} {name!r}")


def _escaped(key: str) -> str:
    return key.replace("~", "~0").replace("/", "~1")


def tracks_to_dict(tracks: Tracks, encoding: str, sidecar: str | None) -> dict[str, Any]:
    """The tracks as the file has them: with the name of the WAV file beside it, or with their samples. Raises ValueError where those are
    too many to stand in a file."""
    form: dict[str, Any] = {"sample_rate": tracks.sample_rate, "start": tracks.start}
    listeners: list[dict[str, Any]] = [
        {"name": track.name, "body_part": track.body_part, "impacts": track.impacts.tolist()} for track in tracks.listeners
    ]
    if sidecar is not None:
        return {**form, "file": sidecar, "listeners": listeners}
    size = len(listeners) * tracks.count * np.dtype(_TYPES[encoding]).itemsize
    if size > MAX_INLINE:
        raise ValueError(f"tracks: {size / 2**20:.0f} MiB are too many to stand in the scene file: put them into a WAV file beside it")
    blocks = list(encoded(tracks, encoding))
    for number, listener in enumerate(listeners):
        listener["samples"] = base64.b64encode(b"".join(block[number].tobytes() for block in blocks)).decode("ascii")
    return {**form, "encoding": encoding, "listeners": listeners}


def tracks_from_dict(document: Mapping[str, Any], file: str | Path) -> Tracks | None:
    """The tracks of a validated document, or None where it has none. Raises FormatError or OSError."""
    if "tracks" not in document:
        return None
    form = document["tracks"]
    samples = _beside(form, file) if "file" in form else _inline(form, file)
    listeners = []
    for i, track in enumerate(form["listeners"]):
        try:
            listeners.append(ListenerTrack(track["name"], track.get("body_part", ""), np.array(track.get("impacts", [])).reshape(-1, 2)))
        except ValueError as error:
            raise FormatError(file, f"/tracks/listeners/{i}/impacts", str(error).partition(": ")[2]) from None
    try:
        return Tracks(tuple(listeners), int(form["sample_rate"]), samples, float(form.get("start", 0.0)))
    except ValueError as error:
        raise FormatError(file, "/tracks", str(error)) from None


def _beside(form: Mapping[str, Any], file: str | Path) -> NDArray[np.floating]:
    name = form["file"]
    if name != Path(name).name or "\\" in name or ":" in name or name in (".", ".."):
        raise FormatError(file, "/tracks/file", f"{name!r} is not the name of a file in the same folder")
    path = Path(file).parent / name
    try:
        samples, rate = wav_channels(read_bytes(path, MAX_RIFF))
    except OSError as error:
        raise FormatError(file, "/tracks/file", f"{name}: {error.strerror}") from None
    except ValueError as error:
        raise FormatError(file, "/tracks/file", f"{name}: {error}") from None
    if rate != form["sample_rate"] or samples.shape[1] != len(form["listeners"]):
        wanted = f"{len(form['listeners'])} channels at {form['sample_rate']} Hz"
        raise FormatError(file, "/tracks/file", f"{name} has {samples.shape[1]} channels at {rate:g} Hz, not {wanted}")
    return samples.T


def _inline(form: Mapping[str, Any], file: str | Path) -> NDArray[np.floating]:
    kind = np.dtype(_TYPES[form["encoding"]])
    rows: list[NDArray[Any]] = []
    for i, listener in enumerate(form["listeners"]):
        try:
            data = base64.b64decode(listener["samples"], validate=True)
        except (binascii.Error, ValueError):
            raise FormatError(file, f"/tracks/listeners/{i}/samples", "is not base64") from None
        if len(data) % kind.itemsize or (rows and len(data) != rows[0].nbytes):
            raise FormatError(file, f"/tracks/listeners/{i}/samples", f"{len(data)} bytes are no whole samples or not as many as others")
        rows.append(np.frombuffer(data, dtype=kind))
    return np.array(rows) / np.float32(_FULL_SCALE[form["encoding"]])


def device_to_dict(device: DeviceMapping) -> dict[str, Any]:
    """A device as the file has it."""
    form: dict[str, Any] = {
        "name": device.name,
        "profile": device.profile,
        "actuators": [{"actuator": item.actuator, "listener": item.listener, "gain": item.gain} for item in device.actuators],
    }
    return {**form, "extras": dict(device.extras)} if device.extras else form


def devices_from_dict(document: Mapping[str, Any], scene: HapticScene, file: str | Path) -> tuple[DeviceMapping, ...]:
    """The devices of a validated document. Raises FormatError."""
    return tuple(_devices(document.get("devices", []), {item.name for item in scene.listeners}, file))


def _devices(forms: list[Mapping[str, Any]], listeners: set[str], file: str | Path) -> Iterator[DeviceMapping]:
    names: set[str] = set()
    for i, form in enumerate(forms):
        if form["name"] in names:
            raise FormatError(file, f"/devices/{i}/name", f"there is a device {form['name']!r} already")
        names.add(form["name"])
        for k, item in enumerate(form.get("actuators", [])):
            if item["listener"] not in listeners:
                raise FormatError(file, f"/devices/{i}/actuators/{k}/listener", f"there is no listener {item['listener']!r}")
        actuators = tuple(ActuatorMapping(a["actuator"], a["listener"], a.get("gain", 1.0)) for a in form.get("actuators", []))
        yield DeviceMapping(form["name"], form["profile"], actuators, form.get("extras", {}))
