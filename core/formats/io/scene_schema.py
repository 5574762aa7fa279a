"""The JSON Schema of haptic scenes: its outline, and the definitions of the items, which follow
from the declarations of their fields."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import MISSING, Field
from pathlib import Path
from typing import Any

from ...declaration import declared, schema_of
from ...forms import Form, JsonObject
from ...scene.device_mapping import ActuatorMapping, DeviceMapping
from ...scene.functions import TRANSMISSIONS, Spectrum
from ...scene.impact_rule import ImpactLimits, ImpactRule
from ...scene.joint import Joint
from ...scene.library import LibraryMaterial
from ...scene.rules import ContactSettings
from ...scene.texture import Texture
from ...scene.values import Contact, HapticObject, Listener, Settings, Source
from ...signals import SIGNAL_KINDS
from ...signals.automation import Parameter
from ...signals.base import json_fields

SCENE = "haptic-scene-1.1"
"""The name of the schema."""

DEFINED: dict[str, type] = {
    "settings": Settings,
    "rules": ContactSettings,
    "impact_rule": ImpactRule,
    "impact_limits": ImpactLimits,
    "joint": Joint,
    "texture": Texture,
    "object": HapticObject,
    "contact": Contact,
    "source": Source,
    "listener": Listener,
    "material": LibraryMaterial,
    "device": DeviceMapping,
    "actuator": ActuatorMapping,
}
"""The classes of the items by the names of their definitions."""


def function_schema() -> JsonObject:
    """The definition of modulation functions: each has its own parameters, and all have those of
    the spectrum."""
    properties: JsonObject = {}
    owners: dict[str, list[str]] = {}
    for name, cls in TRANSMISSIONS.items():
        for key, item in schema_of(cls)["properties"].items():
            properties.setdefault(key, item)
            owners.setdefault(key, []).append(name)
    alike: dict[tuple[str, ...], list[str]] = {}
    for key, names in owners.items():
        alike.setdefault(tuple(names), []).append(key)
    about = " ".join(f'"{name}": {cls.about}.' for name, cls in TRANSMISSIONS.items())
    choice = {"description": f"The kind. {about}", "enum": list(TRANSMISSIONS)}
    return {
        "type": "object",
        "properties": {"function": choice, **properties, **schema_of(Spectrum)["properties"]},
        "required": ["function"],
        "additionalProperties": False,
        "allOf": [
            {
                "if": {"properties": {"function": {"enum": list(names)}}},
                "else": {"properties": dict.fromkeys(keys, False)},
            }
            for names, keys in alike.items()
        ],
    }


def signal_schema(outline: Form) -> JsonObject:
    """The definition of signals: each kind has its own parameters. ``outline``: those that are not
    numbers."""
    kinds = {kind: json_fields(cls) for kind, cls in SIGNAL_KINDS.items()}
    properties: JsonObject = {"signal": {"description": "Kind of signal.", "enum": list(kinds)}}
    numbers = {
        kind: {
            item.key or name: {"description": f"{item.about}.", **item.schema()}
            for name, item in declared(cls).items()
            if isinstance(item, Parameter)
        }
        for kind, cls in SIGNAL_KINDS.items()
    }
    for found in numbers.values():
        for key, item in found.items():
            properties[key] = _either(properties.get(key, item), item)
    for key in properties.keys() - {"signal"}:
        properties[key]["description"] += _defaults_in(key, kinds)
    rules = []
    for kind, own in kinds.items():
        narrow = {
            key: _limits(item)
            for key, item in numbers[kind].items()
            if _limits(item) != _limits(properties[key])
        }
        if "of" in own:
            narrow["of"] = declared(SIGNAL_KINDS[kind])["of"].schema()
        required = [key for key, entry in own.items() if entry.default is MISSING]
        then = {
            "propertyNames": {"enum": ["signal", *own]},
            "required": required,
            "properties": narrow,
        }
        given = {key: value for key, value in then.items() if value}
        rules.append({"if": {"properties": {"signal": {"const": kind}}}, "then": given})
    return {
        "type": "object",
        "properties": {**properties, **outline["properties"]},
        "required": ["signal"],
        "additionalProperties": False,
        "allOf": rules,
    }


def _defaults_in(key: str, kinds: Mapping[str, Mapping[str, Field[Any]]]) -> str:
    """The sentence about the default of a parameter, by kinds of signals where they differ."""
    owners: dict[float, list[str]] = {}
    for kind, own in kinds.items():
        default = own[key].default if key in own else MISSING
        if isinstance(default, int | float) and math.isfinite(default):
            owners.setdefault(default, []).append(kind)
    if len(owners) == 1:
        return f" Default: {next(iter(owners)):g}."
    parts = [f"{value:g} of {', '.join(names)}" for value, names in owners.items()]
    return f" Defaults: {'; '.join(parts)}." if parts else ""


def _limits(item: Form) -> JsonObject:
    """A schema without its description."""
    return {key: value for key, value in item.items() if key != "description"}


def _either(first: Form, second: Form) -> JsonObject:
    """The schema of a parameter that two kinds of signals have, with the limits of both."""
    description = " ".join(dict.fromkeys((first["description"], second["description"])))
    for item in (first, second):
        if "$ref" in item:
            return {"description": description, "$ref": item["$ref"]}
    low = min(first["minimum"], second["minimum"])
    high = max(first["maximum"], second["maximum"])
    return {"description": description, "type": first["type"], "minimum": low, "maximum": high}


def scene_schema() -> JsonObject:
    """The schema as a JSON document."""
    document: JsonObject = json.loads(
        Path(__file__).with_name("scene_outline.json").read_text("utf-8")
    )
    definitions = document["$defs"]
    for name, cls in DEFINED.items():
        outline = definitions[name]
        item = schema_of(cls)
        definitions[name] = {
            **outline,
            **item,
            "required": outline.get("required", item["required"]),
            "properties": {**outline.get("properties", {}), **item["properties"]},
        }
    definitions["function"] |= function_schema()
    definitions["signal"] |= signal_schema(definitions["signal"])
    return document
