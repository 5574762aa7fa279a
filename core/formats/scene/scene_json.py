"""The haptic scene JSON 1.0: reading and writing `HapticScene`."""

from __future__ import annotations

import gzip
import json
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, fields
from enum import Enum
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ...contacts.shapes import Shape, shape_from_dict
from ...scene.functions import ModulationFunction, function_from_dict
from ...scene.values import Contact, HapticObject, HapticScene, Listener, Pose, Settings, Source
from ...signals import Signal, signal_from_dict
from ..io.atomic import atomic_file
from ..io.error import FormatError, json_pointer
from ..io.schema import validate
from ..io.strict_json import read_json

T = TypeVar("T")
Place = tuple[str | int, ...]

FORMAT = "haptic-scene"
VERSION = "1.0"

Migration = Callable[[dict[str, Any]], dict[str, Any]]

MIGRATIONS: dict[str, Migration] = {}
"""From a version to the function that turns its document into one of a later version (it sets ``version``)."""


def read_scene(path: str | Path) -> HapticScene:
    """The scene in a ``.json`` or ``.json.gz`` file. Raises FormatError (file, JSON pointer, reason in one line) or OSError."""
    return scene_from_dict(read_json(path), path)


def write_scene(scene: HapticScene, path: str | Path) -> None:
    """Write a scene as ``.json``, or packed as ``.json.gz``, in one step."""
    write_document(scene_to_dict(scene), path)


def write_document(document: Mapping[str, Any], path: str | Path) -> None:
    """Write a scene's document with one item of its lists a line, in one step. The same document gives the same bytes."""
    with atomic_file(path) as file:
        if Path(path).suffix.lower() == ".gz":
            with gzip.GzipFile(filename="", mode="wb", fileobj=file, mtime=0) as packed:
                packed.writelines(line.encode("utf-8") for line in _lines(document))
        else:
            file.writelines(line.encode("utf-8") for line in _lines(document))


def scene_from_dict(document: Any, file: str | Path) -> HapticScene:
    """The scene of a parsed document; ``file`` names it in errors. Raises FormatError."""
    document = current_document(document, file)
    validate(document, "haptic-scene-1.0", file)
    read = SceneReader(file)
    _check_names(document, file)
    return HapticScene(
        objects=tuple(read.object(form, ("objects", i)) for i, form in enumerate(document["objects"])),
        contacts=tuple(read.contact(form, ("contacts", i)) for i, form in enumerate(document.get("contacts", []))),
        sources=tuple(read.source(form, ("sources", i)) for i, form in enumerate(document.get("sources", []))),
        listeners=tuple(read.listener(form, ("listeners", i)) for i, form in enumerate(document.get("listeners", []))),
        settings=read.made(Settings, document.get("settings", {}), ("settings",)),
        extras=document.get("extras", {}),
    )


def current_document(document: Any, file: str | Path) -> Any:
    """The document in the current version. Raises FormatError for what is no haptic scene, or of a version that can't be read."""
    if not isinstance(document, dict):
        raise FormatError(file, "/", "not a haptic scene: the document must be an object")
    if document.get("format") != FORMAT:
        raise FormatError(file, "/format", f'not a haptic scene: must be "{FORMAT}"')
    while (version := document.get("version")) != VERSION:
        if not isinstance(version, str) or version not in MIGRATIONS:
            raise FormatError(file, "/version", f'this reads version "{VERSION}"{_older()}, not {json.dumps(version)[:40]}')
        document = MIGRATIONS[version](document)
    return document


def _older() -> str:
    return "".join(f' or "{version}"' for version in MIGRATIONS)


def _check_names(document: Mapping[str, Any], file: str | Path) -> None:
    """Names unique within their list, references that resolve, no object that touches itself."""
    for key in ("objects", "sources", "listeners"):
        first: dict[str, int] = {}
        for i, form in enumerate(document.get(key, [])):
            if form["name"] in first:
                raise FormatError(file, f"/{key}/{i}/name", f"{form['name']!r} is the name of /{key}/{first[form['name']]} already")
            first[form["name"]] = i
    names = {form["name"] for form in document["objects"]}
    for i, form in enumerate(document.get("contacts", [])):
        for k, name in enumerate(form["objects"]):
            if name not in names:
                raise FormatError(file, f"/contacts/{i}/objects/{k}", f"there is no object {name!r}")
        if form["objects"][0] == form["objects"][1]:
            raise FormatError(file, f"/contacts/{i}/objects", f"{form['objects'][0]!r} can't touch itself")
    for key in ("sources", "listeners"):
        for i, form in enumerate(document.get(key, [])):
            for reference in ("object", "second_object"):
                if reference in form and form[reference] not in names:
                    raise FormatError(file, f"/{key}/{i}/{reference}", f"there is no object {form[reference]!r}")


class SceneReader:
    """Makes values from validated forms; an error of theirs is reported with its place."""

    def __init__(self, file: str | Path) -> None:
        self.file = file

    def made(self, make: Callable[..., T], arguments: Mapping[str, Any], place: Place) -> T:
        try:
            return make(**{key: tuple(v) if isinstance(v, list) else v for key, v in arguments.items()})
        except ValueError as error:
            raise self.error(str(error), place, arguments) from None

    def error(self, message: str, place: Place, form: Mapping[str, Any]) -> FormatError:
        """From a value's ``key: reason`` or ``key/key: reason``."""
        keys, _, reason = message.partition(": ")
        parts = keys.removeprefix("/").split("/")
        return FormatError(self.file, json_pointer((*place, *parts) if parts[0] in form else place), reason or keys)

    def function(self, form: Mapping[str, Any], place: Place) -> ModulationFunction:
        try:
            return function_from_dict(form)
        except ValueError as error:
            raise self.error(str(error), place, form) from None

    def object(self, form: Mapping[str, Any], place: Place) -> HapticObject:
        arguments = dict(form)
        if "propagation" in form:
            arguments["propagation"] = self.function(form["propagation"], (*place, "propagation"))
        if "pose" in form:
            arguments["pose"] = self.made(Pose, form["pose"], (*place, "pose"))
        if "shape" in form:
            try:
                arguments["shape"] = shape_from_dict(form["shape"])
            except ValueError as error:
                raise self.error(str(error), (*place, "shape"), form["shape"]) from None
        return self.made(HapticObject, arguments, place)

    def contact(self, form: Mapping[str, Any], place: Place) -> Contact:
        arguments = dict(form)
        if "transmission" in form:
            arguments["transmission"] = self.function(form["transmission"], (*place, "transmission"))
        if "normal" in form:
            length = math.hypot(*form["normal"])
            if length < 1e-12:
                raise FormatError(self.file, json_pointer((*place, "normal")), "a vector of length 0 has no direction")
            if abs(length - 1) > 1e-6:
                arguments["normal"] = tuple(component / length for component in form["normal"])
        return self.made(Contact, arguments, place)

    def source(self, form: Mapping[str, Any], place: Place) -> Source:
        arguments = dict(form)
        if "signal" in form:
            try:
                arguments["signal"] = signal_from_dict(form["signal"])
            except ValueError as error:
                raise self.error(str(error), (*place, "signal"), form["signal"]) from None
        return self.made(Source, arguments, place)

    def listener(self, form: Mapping[str, Any], place: Place) -> Listener:
        return self.made(Listener, form, place)


def scene_to_dict(scene: HapticScene) -> dict[str, Any]:
    """The document of a scene. Keys have the order of the definition; what has its default is left out, but for positions and settings."""
    document: dict[str, Any] = {
        "format": FORMAT,
        "version": VERSION,
        "settings": {
            key.name: _plain(value) for key in fields(Settings) if (value := getattr(scene.settings, key.name)) or key.name != "localise"
        },
        "objects": [item_to_dict(item) for item in scene.objects],
        "contacts": [item_to_dict(item) for item in scene.contacts],
        "sources": [item_to_dict(item) for item in scene.sources],
        "listeners": [item_to_dict(item) for item in scene.listeners],
    }
    if scene.extras:
        document["extras"] = _plain(scene.extras)
    return document


def item_to_dict(item: HapticObject | Contact | Source | Listener) -> dict[str, Any]:
    """As the file has it, without what has its default."""
    form: dict[str, Any] = {}
    for key in fields(item):
        value = getattr(item, key.name)
        default = key.default if key.default_factory is MISSING else key.default_factory()
        if value != default or key.name == "position":
            form[key.name] = _plain(value)
    return form


def _plain(value: Any) -> Any:
    """As JSON has it."""
    match value:
        case None | bool() | float() | int():
            return value
        case Enum():
            return value.value
        case str():
            return value
        case Pose():
            return {"position": list(value.position), "rotation": list(value.rotation)}
        case ModulationFunction() | Shape() | Signal():
            return value.to_dict()
        case Mapping():
            return {key: _plain(member) for key, member in value.items()}
        case list() | tuple():
            return [_plain(member) for member in value]
        case np.generic() | np.ndarray():
            return value.tolist()
        case _:
            raise TypeError(f"{type(value).__name__} has no form in a scene file")


def _lines(document: Mapping[str, Any]) -> Iterator[str]:
    """The text of a document: its lists, which may be made while they are written, with one item a line."""
    separator = "{\n"
    for key, value in document.items():
        yield f"{separator} {_text(key)}: "
        separator = ",\n"
        if isinstance(value, list | Iterator):
            opening = "["
            for item in value:
                yield f"{opening}\n  {_text(item)}"
                opening = ","
            yield "[]" if opening == "[" else "\n ]"
        else:
            yield _text(value)
    yield "\n}\n"


def _text(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
