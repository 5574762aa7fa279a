"""The frames of a haptic scene file, which contain changes over time."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from ...forms import Form, JsonObject
from ...scene.references import Place, PlacedError, require_known, require_new
from ...scene.values import HapticScene, Pose
from ..io.error import errors_in
from .motion import unpacked
from .recording import CHANGES, Poses, RecordedFrame, Recording, SceneState, by_pair
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
        self.state = SceneState(scene)
        self.last: int | None = None

    def frame(self, form: Form, place: Place) -> RecordedFrame:
        number = int(form["frame"])
        if self.last is not None and number <= self.last:
            raise PlacedError((*place, "frame"), f"must come after {self.last}, the frame before")
        self.last = number
        frame = _read_frame(form, place)
        self._remove(frame, place)
        self._add(frame, place)
        for key, (kind, _) in CHANGES.items():
            for name in getattr(frame, key):
                known: Collection[str] = getattr(self.state, kind)
                require_known(name, known, kind.removesuffix("s"), (*place, key, name))
        for i, contact in enumerate(frame.contacts):
            for k, name in enumerate(contact.objects):
                own = (*place, "contacts", i, "objects", k)
                require_known(name, self.state.objects, "object", own)
        self.state.contacts.update(by_pair(frame.contacts))
        return frame

    def moved(self, frame: RecordedFrame, moving: dict[int, Poses], place: Place) -> RecordedFrame:
        """The frame that was read last with the poses of its motions, which are removed from
        ``moving``."""
        poses = moving.pop(frame.number, None)
        if poses is None:
            return frame
        for name in poses.names:
            if name not in self.state.objects:
                raise PlacedError(
                    ("motions",), f"there is no object {name!r} in frame {frame.number}"
                )
        for name in frame.poses:
            if name in poses:
                raise PlacedError(
                    (*place, "poses", name), "a motion has a pose for this frame, too"
                )
        return replace(frame, poses={**poses, **frame.poses} if frame.poses else poses)

    def _remove(self, frame: RecordedFrame, place: Place) -> None:
        """Check what parts and what disappears, and remove it."""
        state = self.state
        for i, pair in enumerate(frame.parted):
            if state.contacts.pop(pair, None) is None:
                raise PlacedError(
                    (*place, "parted", i), f"{pair[0]!r} and {pair[1]!r} did not touch"
                )
        for key, known in (("object", state.objects), ("listener", state.listeners)):
            for i, name in enumerate(getattr(frame, f"removed_{key}s")):
                require_known(name, known, key, (*place, f"removed_{key}s", i))
        state.remove(frame)

    def _add(self, frame: RecordedFrame, place: Place) -> None:
        """Check what appears, and add it; sources exist from now on."""
        state = self.state
        for i, item in enumerate(frame.objects):
            require_new(item.name, state.objects, "object", (*place, "objects", i, "name"))
            state.objects[item.name] = item
        for i, listener in enumerate(frame.listeners):
            own = (*place, "listeners", i)
            require_new(listener.name, state.listeners, "listener", (*own, "name"))
            require_known(listener.object, state.objects, "object", (*own, "object"))
            state.listeners[listener.name] = listener
        for i, source in enumerate(frame.sources):
            own = (*place, "sources", i)
            before = state.sources.get(source.name)
            if not (source.rubs and before is not None and before.rubs):
                require_new(source.name, state.sources, "source", (*own, "name"))
            state.sources[source.name] = source
            for key in ("object", "second_object"):
                if (name := getattr(source, key)) is not None:
                    require_known(name, state.objects, "object", (*own, key))


def _read_frame(form: Form, place: Place) -> RecordedFrame:
    """A frame as in the file; the names in it are not checked against the scene's."""
    for name, row in form.get("poses", {}).items():
        read_value(Pose, {"position": row[:3], "rotation": row[3:]}, (*place, "poses", name))
    read = {
        "functions": {
            name: read_function(function, (*place, "functions", name))
            for name, function in form.get("functions", {}).items()
        },
        "source_positions": {
            name: tuple(map(tuple, places))
            for name, places in form.get("source_positions", {}).items()
        },
        "parted": tuple((min(pair), max(pair)) for pair in form.get("parted", [])),
        **{key: read_items(form, key, read, place) for key, read in _ITEMS.items()},
    }
    others = {key: _as_tuples(value) for key, value in form.items() if key != "frame"}
    return RecordedFrame(int(form["frame"]), **{**others, **read})


_ITEMS: Mapping[str, Callable[[Any, Place], Any]] = {
    "objects": read_object,
    "listeners": read_listener,
    "sources": read_source,
    "contacts": read_contact,
}
"""Readers of the lists of a frame."""
