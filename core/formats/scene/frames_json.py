"""The frames of a haptic scene file: what changes over time."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...scene.references import Place, PlacedError, require_known
from ...scene.values import Contact, HapticScene, Pose, Source
from ..io.error import errors_in
from .motion import unpacked
from .poses import Poses
from .recording import RecordedFrame, Recording, pair_of
from .values_json import item_to_dict, read_contact, read_function, read_source, read_value


def frame_to_dict(frame: RecordedFrame) -> dict[str, Any]:
    """The JSON object of a frame, without what did not change."""
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
    with errors_in(file):
        frames = document.get("frames", [])
        moving = unpacked(document.get("motions", []), {item.name for item in scene.objects})
        if not frames:
            if moving:
                raise PlacedError(("frames",), "is required where there are motions")
            return None
        if "frame_rate" not in document:
            raise PlacedError(("frame_rate",), "is required where there are frames")
        reader = _FrameReader(scene)
        recorded = tuple(_moved(reader.frame(form, ("frames", i)), moving, ("frames", i)) for i, form in enumerate(frames))
        if moving:
            raise PlacedError(("motions",), f"frame {min(moving)} is not among the frames")
        return Recording(float(document["frame_rate"]), int(document.get("frame_start", recorded[0].number)), recorded)


def _moved(frame: RecordedFrame, moving: dict[int, Poses], place: Place) -> RecordedFrame:
    """A frame with the poses of its motions, which are removed from ``moving``."""
    poses = moving.pop(frame.number, None)
    if poses is None:
        return frame
    for name in frame.poses:
        if name in poses:
            raise PlacedError((*place, "poses", name), "a motion has a pose for this frame, too")
    return replace(frame, poses={**poses, **frame.poses} if frame.poses else poses)


class _FrameReader:
    """Reads frames in order and keeps track of what exists, so that every reference is checked."""

    def __init__(self, scene: HapticScene) -> None:
        self.objects = {item.name for item in scene.objects}
        self.sources = {item.name for item in scene.sources}
        self.listeners = {item.name for item in scene.listeners}
        self.touching = {pair_of(contact) for contact in scene.contacts}
        self.last: int | None = None

    def frame(self, form: Mapping[str, Any], place: Place) -> RecordedFrame:
        number = int(form["frame"])
        if self.last is not None and number <= self.last:
            raise PlacedError((*place, "frame"), f"must come after {self.last}, the frame before")
        self.last = number
        sources = self._sources(form, place)
        self._check_names(form, place)
        for name, row in form.get("poses", {}).items():
            read_value(Pose, {"position": row[:3], "rotation": row[3:]}, (*place, "poses", name))
        contacts = self._contacts(form, place)
        return RecordedFrame(
            number=number,
            poses={name: tuple(row) for name, row in form.get("poses", {}).items()},
            properties={name: (row[0], row[1]) for name, row in form.get("properties", {}).items()},
            functions={name: read_function(f, (*place, "functions", name)) for name, f in form.get("functions", {}).items()},
            amplitudes=form.get("amplitudes", {}),
            source_positions={
                name: tuple((x, y, z) for x, y, z in positions) for name, positions in form.get("source_positions", {}).items()
            },
            listener_positions={name: (x, y, z) for name, (x, y, z) in form.get("listener_positions", {}).items()},
            gains=form.get("gains", {}),
            contacts=contacts,
            parted=self._parted(form, contacts, place),
            sources=sources,
        )

    def _sources(self, form: Mapping[str, Any], place: Place) -> tuple[Source, ...]:
        """The sources that begin; they exist from now on."""
        sources = tuple(read_source(source, (*place, "sources", i)) for i, source in enumerate(form.get("sources", [])))
        for i, source in enumerate(sources):
            if source.name in self.sources:
                raise PlacedError((*place, "sources", i, "name"), f"there is a source {source.name!r} already")
            self.sources.add(source.name)
            require_known(source.object, self.objects, "object", (*place, "sources", i, "object"))
            if source.second_object is not None:
                require_known(source.second_object, self.objects, "object", (*place, "sources", i, "second_object"))
        return sources

    def _check_names(self, form: Mapping[str, Any], place: Place) -> None:
        named: tuple[tuple[str, Container[str], tuple[str, ...]], ...] = (
            ("object", self.objects, ("poses", "properties", "functions")),
            ("source", self.sources, ("amplitudes", "source_positions")),
            ("listener", self.listeners, ("listener_positions", "gains")),
        )
        for kind, known, keys in named:
            for key in keys:
                for name in form.get(key, {}):
                    require_known(name, known, kind, (*place, key, name))

    def _contacts(self, form: Mapping[str, Any], place: Place) -> tuple[Contact, ...]:
        contacts = tuple(read_contact(contact, (*place, "contacts", i)) for i, contact in enumerate(form.get("contacts", [])))
        for i, contact in enumerate(contacts):
            for k, name in enumerate(contact.objects):
                require_known(name, self.objects, "object", (*place, "contacts", i, "objects", k))
        return contacts

    def _parted(self, form: Mapping[str, Any], contacts: tuple[Contact, ...], place: Place) -> tuple[tuple[str, str], ...]:
        """The pairs that part; those that touch are known from now on."""
        parted = tuple((min(pair), max(pair)) for pair in form.get("parted", []))
        for i, pair in enumerate(parted):
            if pair not in self.touching:
                raise PlacedError((*place, "parted", i), f"{pair[0]!r} and {pair[1]!r} did not touch")
            self.touching.remove(pair)
        self.touching.update(pair_of(contact) for contact in contacts)
        return parted
