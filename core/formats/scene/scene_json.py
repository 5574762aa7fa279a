"""Haptic scene JSON 1.1: reading and writing `HapticScene`."""

from __future__ import annotations

import gzip
import json
from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import fields
from pathlib import Path
from typing import Any

from ...declaration import default_of
from ...forms import Form, JsonObject
from ...scene.rules import ContactSettings
from ...scene.values import HapticScene, Settings
from ..io.atomic import atomic_file
from ..io.error import FormatError, errors_in
from ..io.json_text import compact
from ..io.scene_schema import SCENE
from ..io.schema import validate
from .values_json import (
    json_value,
    read_contact,
    read_items,
    read_listener,
    read_object,
    read_rules,
    read_source,
    read_value,
    scene_items,
)

FORMAT = "haptic-scene"
VERSION = "1.1"

CONVENTION = {
    "axes": "right-handed, z up",
    "length": "m",
    "mass": "kg",
    "time": "s",
    "energy": "J",
    "rotation": "quaternion w, x, y, z",
}
"""Axes and units of every scene file."""


def write_document(document: Form, path: str | Path) -> None:
    """Write a scene's document in one step, one list item per line. The same document gives the
    same bytes."""
    is_packed = Path(path).suffix.lower() == ".gz"
    with (
        atomic_file(path) as file,
        gzip.GzipFile("", "wb", fileobj=file, mtime=0)
        if is_packed
        else nullcontext(file) as written,
    ):
        written.writelines(line.encode("utf-8") for line in _lines(document))


def scene_from_dict(document: Any, file: str | Path) -> HapticScene:
    """The scene of a parsed document; ``file`` names it in errors. Raises FormatError."""
    return scene_of(valid_document(document, file), file)


PROVENANCE = "provenance"
"""Where a scene file has its provenance among its extras."""


def scene_of(document: Form, file: str | Path) -> HapticScene:
    """The scene of a document from `valid_document`, without the provenance among its extras:
    the next file has its own. Raises FormatError."""
    with errors_in(file):
        return HapticScene(
            objects=read_items(document, "objects", read_object),
            contacts=read_items(document, "contacts", read_contact),
            sources=read_items(document, "sources", read_source),
            listeners=read_items(document, "listeners", read_listener),
            settings=read_value(Settings, document.get("settings", {}), ("settings",)),
            extras={
                key: value for key, value in document.get("extras", {}).items() if key != PROVENANCE
            },
            rules=read_rules(document.get("rules", {}), ("rules",)),
        )


def valid_document(document: Any, file: str | Path) -> JsonObject:
    """The document, if it is a valid haptic scene. Raises FormatError."""
    if not isinstance(document, dict):
        raise FormatError(file, "/", "not a haptic scene: the document must be an object")
    if document.get("format") != FORMAT:
        raise FormatError(file, "/format", f'not a haptic scene: must be "{FORMAT}"')
    version = document.get("version")
    if version != VERSION:
        found = json.dumps(version)[:40]
        raise FormatError(file, "/version", f'this reads version "{VERSION}", not {found}')
    validate(document, SCENE, file)
    return document


def scene_to_dict(scene: HapticScene) -> JsonObject:
    """The document of a scene, keys in the order of the definition; defaults are left out, except
    positions and settings."""
    head = {"format": FORMAT, "version": VERSION, "convention": CONVENTION}
    document = {
        **head,
        "settings": _all_values(scene.settings),
        "rules": _all_values(scene.rules),
        **scene_items(scene),
    }
    return {**document, "extras": json_value(scene.extras)} if scene.extras else document


def _all_values(item: Settings | ContactSettings) -> JsonObject:
    """The JSON object of an item with all its values but those that are empty by default."""
    kind: type = type(item)
    values = {key.name: json_value(getattr(item, key.name)) for key in fields(item)}
    return {
        name: value
        for name, value in values.items()
        if value not in (None, []) or json_value(default_of(kind, name))
    }


def _lines(document: Form) -> Iterator[str]:
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
