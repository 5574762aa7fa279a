"""The JSON Schema of haptic scenes: its outline, and the definitions of the items, which follow from the declarations of their fields."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ...scene.declaration import schema_of
from ...scene.values import Listener

SCENE = "haptic-scene-1.1"
"""The name of the schema."""

DEFINED: dict[str, type] = {"listener": Listener}
"""The classes of the items by the names of their definitions."""


def scene_schema() -> dict[str, Any]:
    """The schema as a JSON document."""
    document: dict[str, Any] = json.loads(Path(__file__).with_name("scene_outline.json").read_text("utf-8"))
    for name, cls in DEFINED.items():
        document["$defs"][name] |= schema_of(cls)
    return document
