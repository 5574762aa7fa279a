"""The JSON Schema of haptic scenes: its outline, and the definitions of the items, which follow from the declarations of their fields."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ...scene.declaration import schema_of
from ...scene.device_mapping import ActuatorMapping, DeviceMapping
from ...scene.functions import TRANSMISSIONS, Spectrum
from ...scene.impact_rule import ImpactLimits, ImpactRule
from ...scene.library import LibraryMaterial
from ...scene.rules import ContactSettings
from ...scene.texture import Texture
from ...scene.values import Contact, HapticObject, Listener, Settings, Source

SCENE = "haptic-scene-1.1"
"""The name of the schema."""

DEFINED: dict[str, type] = {
    "settings": Settings,
    "rules": ContactSettings,
    "impact_rule": ImpactRule,
    "impact_limits": ImpactLimits,
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


def function_schema() -> dict[str, Any]:
    """The definition of modulation functions: each has its own parameters, and all have those of the spectrum."""
    properties: dict[str, Any] = {}
    owners: dict[str, list[str]] = {}
    for name, cls in TRANSMISSIONS.items():
        for key, item in schema_of(cls)["properties"].items():
            properties.setdefault(key, item)
            owners.setdefault(key, []).append(name)
    about = " ".join(f'"{name}": {cls.about}.' for name, cls in TRANSMISSIONS.items())
    choice = {"description": f"The kind. {about}", "enum": list(TRANSMISSIONS)}
    return {
        "type": "object",
        "properties": {"function": choice, **properties, **schema_of(Spectrum)["properties"]},
        "required": ["function"],
        "additionalProperties": False,
        "allOf": [
            {"if": {"properties": {"function": {"enum": names}}}, "else": {"properties": {key: False}}} for key, names in owners.items()
        ],
    }


def scene_schema() -> dict[str, Any]:
    """The schema as a JSON document."""
    document: dict[str, Any] = json.loads(Path(__file__).with_name("scene_outline.json").read_text("utf-8"))
    definitions = document["$defs"]
    for name, cls in DEFINED.items():
        outline, item = definitions[name], schema_of(cls)
        definitions[name] = {**outline, **item, "properties": {**outline.get("properties", {}), **item["properties"]}}
    definitions["function"] |= function_schema()
    return document
