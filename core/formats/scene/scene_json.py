"""Haptic scene JSON 1.0: reading and writing `HapticScene`."""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from ...scene.values import HapticScene, Settings, Strategy
from ..io.atomic import atomic_file
from ..io.error import FormatError, errors_in
from ..io.json_text import compact
from ..io.schema import validate
from ..io.strict_json import read_json
from .values_json import json_value, read_contact, read_listener, read_object, read_source, read_value, scene_items

FORMAT = "haptic-scene"
VERSION = "1.0"

Migration = Callable[[dict[str, Any]], dict[str, Any]]

MIGRATIONS: dict[str, Migration] = {}
"""By version: the function that makes a document of a later version (it sets ``version``)."""


def read_scene(path: str | Path) -> HapticScene:
    """The scene in a ``.json`` or ``.json.gz`` file. Raises FormatError or OSError."""
    return scene_from_dict(read_json(path), path)


def write_scene(scene: HapticScene, path: str | Path) -> None:
    """Write a scene as ``.json``, or compressed as ``.json.gz``, in one step."""
    write_document(scene_to_dict(scene), path)


def write_document(document: Mapping[str, Any], path: str | Path) -> None:
    """Write a scene's document in one step, one list item per line. The same document gives the same bytes."""
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
    with errors_in(file):
        return HapticScene(
            objects=tuple(read_object(form, ("objects", i)) for i, form in enumerate(document["objects"])),
            contacts=tuple(read_contact(form, ("contacts", i)) for i, form in enumerate(document.get("contacts", []))),
            sources=tuple(read_source(form, ("sources", i)) for i, form in enumerate(document.get("sources", []))),
            listeners=tuple(read_listener(form, ("listeners", i)) for i, form in enumerate(document.get("listeners", []))),
            settings=_read_settings(document.get("settings", {})),
            extras=document.get("extras", {}),
        )


def _read_settings(form: Mapping[str, Any]) -> Settings:
    """Settings of version 1.0, in which ``auto``, its default, is the paper's pair of strategies."""
    settings = read_value(Settings, form, ("settings",))
    return replace(settings, strategy=Strategy.AS_IN_THE_PAPER) if settings.strategy is Strategy.AUTO else settings


def _in_version_1_0(settings: Settings) -> Settings:
    """Settings with the same meaning in version 1.0: `Strategy.AUTO` is the best path over any number of connections."""
    if settings.strategy is Strategy.AUTO:
        return replace(settings, strategy=Strategy.BEST_PATH, max_connections=None)
    return replace(settings, strategy=Strategy.AUTO) if settings.strategy is Strategy.AS_IN_THE_PAPER else settings


def current_document(document: Any, file: str | Path) -> Any:
    """The document in the current version. Raises FormatError for anything but a haptic scene of a known version."""
    if not isinstance(document, dict):
        raise FormatError(file, "/", "not a haptic scene: the document must be an object")
    if document.get("format") != FORMAT:
        raise FormatError(file, "/format", f'not a haptic scene: must be "{FORMAT}"')
    while (version := document.get("version")) != VERSION:
        if not isinstance(version, str) or version not in MIGRATIONS:
            older = "".join(f' or "{known}"' for known in MIGRATIONS)
            raise FormatError(file, "/version", f'this reads version "{VERSION}"{older}, not {json.dumps(version)[:40]}')
        document = MIGRATIONS[version](document)
    return document


def scene_to_dict(scene: HapticScene) -> dict[str, Any]:
    """The document of a scene, keys in the order of the definition; defaults are left out, except positions and settings."""
    own = _in_version_1_0(scene.settings)
    settings = {key.name: json_value(getattr(own, key.name)) for key in fields(Settings)}
    if not scene.settings.localise:
        del settings["localise"]
    document = {"format": FORMAT, "version": VERSION, "settings": settings, **scene_items(scene)}
    return {**document, "extras": json_value(scene.extras)} if scene.extras else document


def _lines(document: Mapping[str, Any]) -> Iterator[str]:
    """The text of a document; its lists, which may be iterators, with one item per line."""
    separator = "{\n"
    for key, value in document.items():
        yield f"{separator} {compact(key)}: "
        separator = ",\n"
        if isinstance(value, list | Iterator):
            opening = "["
            for item in value:
                yield f"{opening}\n  {compact(item)}"
                opening = ","
            yield "[]" if opening == "[" else "\n ]"
        else:
            yield compact(value)
    yield "\n}\n"
