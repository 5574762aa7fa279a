"""JSON of device profiles and haptic players: strict parsing, and validation by the schemas beside this module."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NoReturn


def parse_json(text: str | bytes) -> Any:
    """A JSON document. Raises ValueError with one line for invalid JSON, for NaN and infinities, and for deep nesting."""
    try:
        return json.loads(text, parse_constant=_refuse_constant)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    except ValueError as error:
        raise ValueError(f"is not JSON: {error}") from None


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a number of JSON")


@cache
def _validator(name: str, definition: str) -> Callable[[Any], Any]:
    import fastjsonschema

    schema = json.loads((Path(__file__).parent / f"{name}.schema.json").read_text(encoding="utf-8"))
    validate: Callable[[Any], Any] = fastjsonschema.compile(schema["$defs"][definition] if definition else schema)
    return validate


def schema_fault(document: Any, name: str, definition: str = "") -> tuple[str, str] | None:
    """Place (keys joined by slashes) and reason of the first fault of a document; None if it is valid.

    name: that of the schema, ``<name>.schema.json``. definition: an entry of its ``$defs`` to validate against.
    """
    import fastjsonschema

    try:
        _validator(name, definition)(document)
    except fastjsonschema.JsonSchemaValueException as error:
        return "/".join(map(str, error.path[1:])), error.message.removeprefix(error.name or "").strip()
    return None
