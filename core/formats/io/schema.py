"""Validation by the JSON Schemas of core/formats/schemas, with errors that give file, JSON pointer and reason."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

from .error import FormatError, json_pointer

SCHEMAS = Path(__file__).parents[1] / "schemas"

Place = tuple[str | int, ...]

_LONGEST_VALUE = 60


def validate(document: Any, schema: str, file: str | Path) -> None:
    """Raise FormatError unless ``document``, read from ``file``, is valid by ``schemas/<schema>.schema.json``."""
    import fastjsonschema

    try:
        _validator(schema)(document)
    except fastjsonschema.JsonSchemaValueException as error:
        parts = next(
            (parts for parts, value in _readings(document, (error.name or "data").removeprefix("data"), ()) if value is error.value), ()
        )
        key, reason = _reason(error)
        raise FormatError(file, json_pointer(parts if key is None else (*parts, key)), reason) from None


def load_schema(schema: str) -> dict[str, Any]:
    """The schema as a JSON document."""
    document: dict[str, Any] = json.loads((SCHEMAS / f"{schema}.schema.json").read_text("utf-8"))
    return document


@cache
def _validator(schema: str) -> Callable[[Any], Any]:
    import fastjsonschema

    # The schemas use only keywords with the same meaning in draft 2020-12 and in draft 7, which the validator implements.
    definition = load_schema(schema) | {"$schema": "http://json-schema.org/draft-07/schema#"}
    validator: Callable[[Any], Any] = fastjsonschema.compile(definition, use_default=False)
    return validator


def _readings(value: Any, name: str, parts: Place) -> Iterator[tuple[Place, Any]]:
    """Every place that the validator's name ``.objects[0].kappa`` may mean, since keys may contain dots, with the value there."""
    if not name:
        yield parts, value
    elif isinstance(value, list) and name.startswith("["):
        index, _, rest = name[1:].partition("]")
        yield from _readings(value[int(index)], rest, (*parts, int(index)))
    elif isinstance(value, dict) and name.startswith("."):
        for key, member in value.items():
            if name.startswith(key, 1):
                yield from _readings(member, name[1 + len(key) :], (*parts, key))


def _reason(error: Any) -> tuple[str | None, str]:
    """The key that is wrong, None for the value itself, and the reason."""
    rule, limit, value = error.rule, error.rule_definition, error.value
    match rule:
        case "required":
            return next(key for key in limit if key not in value), "is required"
        case "additionalProperties":
            known = error.definition.get("properties", {})
            return next(key for key in value if key not in known), "unknown key; known are " + ", ".join(known)
        case "type":
            wanted = limit if isinstance(limit, str) else " or ".join(limit)
            return None, f"must be {_article(wanted)}, got {_shown(value)}"
        case "const" | "enum":
            choices = limit if rule == "enum" else [limit]
            return None, f"must be {' or '.join(json.dumps(choice) for choice in choices)}, got {_shown(value)}"
        case "minimum" | "exclusiveMinimum" | "maximum" | "exclusiveMaximum":
            words = {"minimum": "at least", "exclusiveMinimum": "more than", "maximum": "at most", "exclusiveMaximum": "less than"}
            return None, f"must be {words[rule]} {limit:g}, got {_shown(value)}"
        case "minItems" | "maxItems":
            return None, f"must have at {rule[:3].replace('min', 'least').replace('max', 'most')} {limit} items, has {len(value)}"
        case "minLength" | "maxLength":
            return None, f"must have at {rule[:3].replace('min', 'least').replace('max', 'most')} {limit} characters, has {len(value)}"
        case "propertyNames":
            known = limit["enum"]
            return next(key for key in value if key not in known), "does not belong here; known are " + ", ".join(known)
        case None:
            return None, "does not belong here"
        case _:
            return None, error.message.removeprefix(error.name or "").strip()


def _article(kind: str) -> str:
    return f"an {kind}" if kind[0] in "aio" else f"a {kind}"


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, list):
        return "an array"
    text = json.dumps(value) if not isinstance(value, int) or abs(value) < 10**_LONGEST_VALUE else "a huge number"
    return text if len(text) <= _LONGEST_VALUE else text[:_LONGEST_VALUE] + "..."
