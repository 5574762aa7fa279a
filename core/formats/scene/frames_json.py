"""The frames of a haptic scene file, which contain changes over time."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from ...forms import Form, JsonObject
from ...scene.references import Place, PlacedError, require_known, require_new
from ...scene.values import Contact, HapticObject, HapticScene, Listener, Pose, Source
from ..io.error import errors_in
from .motion import unpacked
from .recording import CHANGES, Poses, RecordedFrame, Recording, is_on, pair_of
from .values_json import (
    json_value,
    read_contact,
    read_function,
    read_items,
    read_listener,
    read_object,
    read_source,
    read_value,
)


def frame_to_dict(frame: RecordedFrame) -> JsonObject:
    """The JSON object of a frame, without unchanged values."""
    changes = {key.name: getattr(frame, key.name) for key in fields(frame) if key.name != "number"}
    return {
        "frame": frame.number,
        **{key: dict(v) if key == "poses" else json_value(v) for key, v in changes.items() if v},
    }


def _as_tuples(value: Any) -> Any:
    """Lists, and those in an object, as tuples."""
    if isinstance(value, dict):
        return {name: _as_tuples(member) for name, member in value.items()}
    return tuple(value) if isinstance(value, list) else value


def recording_from_dict(document: Form, scene: HapticScene, file: str | Path) -> Recording | None:
    """The frames of a validated document, or None where it has none. Raises FormatError."""
    with errors_in(file):
        frames = document.get("frames", [])
        known = {item.name for item in scene.objects} | {
            form["name"] for frame in frames for form in frame.get("objects", ())
        }
        moving = unpacked(document.get("motions", []), known)
        if not frames:
            if moving:
                raise PlacedError(("frames",), "is required where there are motions")
            return None
        if "frame_rate" not in document:
            raise PlacedError(("frame_rate",), "is required where there are frames")
        reader = _FrameReader(scene)
        recorded = tuple(
            reader.moved(reader.frame(form, ("frames", i)), moving, ("frames", i))
            for i, form in enumerate(frames)
        )
        if moving:
            raise PlacedError(("motions",), f"frame {min(moving)} is not among the frames")
        return Recording(
            float(document["frame_rate"]),
            int(document.get("frame_start", recorded[0].number)),
            recorded,
        )


class _FrameReader:
    """Reads frames in order and keeps track of what exists, so that every reference is checked."""

    def __init__(self, scene: HapticScene) -> None:
        self.objects = {item.name for item in scene.objects}
        self.sources = {item.name: item for item in scene.sources}
        self.listeners = {item.name: item.object for item in scene.listeners}
        self.touching = {pair_of(contact) for contact in scene.contacts}
        self.last: int | None = None

    def frame(self, form: Form, place: Place) -> RecordedFrame:
        number = int(form["frame"])
        if self.last is not None and number <= self.last:
            raise PlacedError((*place, "frame"), f"must come after {self.last}, the frame before")
        self.last = number
        parted = self._parted(form, place)
        self._remove(form, place)
        objects = self._objects(form, place)
        listeners = self._listeners(form, place)
        sources = self._sources(form, place)
        self._check_names(form, place)
        for name, row in form.get("poses", {}).items():
            read_value(Pose, {"position": row[:3], "rotation": row[3:]}, (*place, "poses", name))
        contacts = self._contacts(form, place)
        functions = {
            name: read_function(function, (*place, "functions", name))
            for name, function in form.get("functions", {}).items()
        }
        positions = {
            name: tuple(map(tuple, places))
            for name, places in form.get("source_positions", {}).items()
        }
        read = {
            "functions": functions,
            "source_positions": positions,
            "contacts": contacts,
            "parted": parted,
            "sources": sources,
        }
        others = {key: _as_tuples(value) for key, value in form.items() if key != "frame"}
        return RecordedFrame(
            number, **{**others, **read, "objects": objects, "listeners": listeners}
        )

    def moved(self, frame: RecordedFrame, moving: dict[int, Poses], place: Place) -> RecordedFrame:
        """The frame that was read last with the poses of its motions, which are removed from
        ``moving``."""
        poses = moving.pop(frame.number, None)
        if poses is None:
            return frame
        if not self.objects.issuperset(poses.names):
            name = next(name for name in poses.names if name not in self.objects)
            raise PlacedError(("motions",), f"there is no object {name!r} in frame {frame.number}")
        for name in frame.poses:
            if name in poses:
                raise PlacedError(
                    (*place, "poses", name), "a motion has a pose for this frame, too"
                )
        return replace(frame, poses={**poses, **frame.poses} if frame.poses else poses)

    def _remove(self, form: Form, place: Place) -> None:
        """Remove objects with the sources and listeners on them, and listeners."""
        for kind, known in (("object", self.objects), ("listener", self.listeners)):
            for i, name in enumerate(form.get(f"removed_{kind}s", ())):
                require_known(name, known, kind, (*place, f"removed_{kind}s", i))
        gone = set(form.get("removed_objects", ()))
        self.objects -= gone
        listeners = gone and {name for name, carrier in self.listeners.items() if carrier in gone}
        for name in {*listeners, *form.get("removed_listeners", ())}:
            del self.listeners[name]
        for name in [name for name, item in self.sources.items() if gone and is_on(item, gone)]:
            del self.sources[name]
        self.touching -= {pair for pair in self.touching if gone and not gone.isdisjoint(pair)}

    def _objects(self, form: Form, place: Place) -> tuple[HapticObject, ...]:
        """The objects that appear."""
        objects = read_items(form, "objects", read_object, place)
        for i, item in enumerate(objects):
            require_new(item.name, self.objects, "object", (*place, "objects", i, "name"))
            self.objects.add(item.name)
        return objects

    def _listeners(self, form: Form, place: Place) -> tuple[Listener, ...]:
        """The listeners that appear."""
        listeners = read_items(form, "listeners", read_listener, place)
        for i, item in enumerate(listeners):
            require_new(item.name, self.listeners, "listener", (*place, "listeners", i, "name"))
            require_known(item.object, self.objects, "object", (*place, "listeners", i, "object"))
            self.listeners[item.name] = item.object
        return listeners

    def _sources(self, form: Form, place: Place) -> tuple[Source, ...]:
        """The sources that begin; they exist from now on."""
        sources = read_items(form, "sources", read_source, place)
        for i, source in enumerate(sources):
            if not (source.rubs and source.name in self.sources and self.sources[source.name].rubs):
                require_new(source.name, self.sources, "source", (*place, "sources", i, "name"))
            self.sources[source.name] = source
            for key in ("object", "second_object"):
                if (name := getattr(source, key)) is not None:
                    require_known(name, self.objects, "object", (*place, "sources", i, key))
        return sources

    def _check_names(self, form: Form, place: Place) -> None:
        for key, (kind, _) in CHANGES.items():
            for name in form.get(key, {}):
                known: Collection[str] = getattr(self, kind)
                require_known(name, known, kind.removesuffix("s"), (*place, key, name))

    def _contacts(self, form: Form, place: Place) -> tuple[Contact, ...]:
        contacts = read_items(form, "contacts", read_contact, place)
        for i, contact in enumerate(contacts):
            for k, name in enumerate(contact.objects):
                require_known(name, self.objects, "object", (*place, "contacts", i, "objects", k))
        self.touching.update(pair_of(contact) for contact in contacts)
        return contacts

    def _parted(self, form: Form, place: Place) -> tuple[tuple[str, str], ...]:
        """The pairs that part."""
        parted = tuple((min(pair), max(pair)) for pair in form.get("parted", []))
        for i, pair in enumerate(parted):
            if pair not in self.touching:
                raise PlacedError(
                    (*place, "parted", i), f"{pair[0]!r} and {pair[1]!r} did not touch"
                )
            self.touching.remove(pair)
        return parted
