"""The frames of a haptic scene file: what changes over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...scene.values import HapticScene, Pose
from ..io.error import FormatError
from .motion import unpacked
from .poses import Poses
from .recording import RecordedFrame, Recording, pair_of
from .scene_json import SceneReader, item_to_dict


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
