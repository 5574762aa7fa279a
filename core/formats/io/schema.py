"""Validation by JSON Schemas, those of core/formats/schemas and of plug-ins, with errors that give
file, JSON pointer and reason."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

from ...forms import JsonObject
from ...frozen import frozen
from ...scene.references import meant
from .error import FormatError, json_pointer
from .scene_schema import SCENE, scene_schema

SCHEMAS = Path(__file__).parents[1] / "schemas"
MESSAGES = "run-time-1"
"""The schema of the messages to a server."""

Place = tuple[str | int, ...]

_LONGEST_VALUE = 60


def validate(document: Any, schema: str | Path, file: str | Path) -> None:
    """Raise FormatError unless ``document``, read from ``file``, is valid by a schema: a file, or
    the name of one in ``schemas``."""
    fault = _fault(document, schema)
    if fault is not None:
        raise FormatError(file, json_pointer(fault.place), fault.reason)


@frozen
class _Fault:
    """The first fault of a document, of the value at ``place``."""

    place: Place
    reason: str


def _fault(document: Any, schema: str | Path) -> _Fault | None:
    import fastjsonschema

    try:
        _validator(schema)(document)
    except fastjsonschema.JsonSchemaValueException as error:
        name = (error.name or "data").removeprefix("data")
        place = next(
            (parts for parts, value in _readings(document, name, ()) if value is error.value), ()
        )
        key, reason = _reason(error)
        return _Fault(place if key is None else (*place, key), reason)
    return None


def load_schema(schema: str | Path) -> JsonObject:
    """The schema of a file, or by its name, as a JSON document. ``haptic-scene-1.1#NAME``: that of
    an object with any of the properties of the definition NAME; ``run-time-1#NAME``: that of a
    message, whose parts are those of scenes."""
    if isinstance(schema, Path):
        document: JsonObject = json.loads(schema.read_text("utf-8"))
        return document
    name, _, part = schema.partition("#")
    if name == MESSAGES:
        messages = json.loads((SCHEMAS / f"{MESSAGES}.schema.json").read_text("utf-8"))
        return {**messages["$defs"][part], "$defs": scene_schema()["$defs"]}
    if name == SCENE:
        scene = scene_schema()
        definitions = scene["$defs"]
        return (
            _alone({"type": "object", "properties": definitions[part]["properties"]}, definitions)
            if part
            else scene
        )
    return load_schema(SCHEMAS / f"{schema}.schema.json")


def _alone(schema: JsonObject, definitions: JsonObject) -> JsonObject:
    """A schema with those of the definitions that it refers to."""
    used: JsonObject = {}
    new = [schema]
    while new:
        names = set(re.findall(r'"#/\$defs/(\w+)"', json.dumps(new))) - used.keys()
        new = [definitions[name] for name in names]
        used |= zip(names, new, strict=True)
    return {**schema, "$defs": used}


@cache
def _validator(schema: str | Path) -> Callable[[Any], Any]:
    """What raises an exception for a document that is not valid.

    Exceptions have their part of the schema from a table, and messages without the name of what is
    wrong: fastjsonschema spells both out in its code, which takes 85 MB and 0.4 s of the processor
    to compile for scenes.
    """
    from fastjsonschema.draft07 import CodeGeneratorDraft07
    from fastjsonschema.ref_resolver import RefResolver

    parts: list[Any] = []

    class Generator(CodeGeneratorDraft07):
        def exc(
            self, msg: str, *args: Any, append_to_msg: str | None = None, rule: str | None = None
        ) -> None:
            text = f'"{msg.removeprefix("{name} ")}"'
            if append_to_msg:
                text += f" + ({append_to_msg})"
            self.l(
                f"raise JsonSchemaValueException({text}, value={{variable}}, "
                f'name="{{name}}", definition=PARTS[{len(parts)}], rule={rule!r})',
                *args,
            )
            parts.append(self._definition)

    # The schemas use only keywords with the same meaning in draft 2020-12 and in draft 7, which the
    # validator implements.
    definition = _with_kinds_first(_with_inlined_leaves(load_schema(schema)))
    resolver = RefResolver.from_schema(definition, store={})
    generator = Generator(definition, resolver, use_default=False)  # type: ignore[no-untyped-call]
    state = {**generator.global_state, "PARTS": parts}
    exec(generator.func_code, state)
    validator: Callable[[Any], Any] = state[resolver.get_scope_name()]
    return validator


def _with_inlined_leaves(definition: JsonObject) -> JsonObject:
    """The schema with the definitions of numbers, texts and arrays of these instead of references
    to them.

    The validator calls a function and formats a name for every reference, which is most of its
    time.
    """
    defined: JsonObject = definition.get("$defs", {})

    def inlined(value: Any) -> Any:
        if isinstance(value, list):
            return [inlined(item) for item in value]
        if not isinstance(value, dict):
            return value
        target = defined.get(str(value.get("$ref", "")).removeprefix("#/$defs/"))
        if (
            target is not None
            and target.get("type") not in (None, "object")
            and "#/$defs/json" not in json.dumps(target)
        ):
            return inlined(target)
        inside = {key: inlined(member) for key, member in value.items()}
        if "const" in inside:  # so that faults of both are said alike
            inside["enum"] = [inside.pop("const")]
        return inside

    inline: JsonObject = inlined(definition)
    return inline


def _with_kinds_first(value: Any) -> Any:
    """The schema in which a kind is checked before what depends on it: "type" of a shape, "signal"
    of a signal. Else an unknown kind would be reported as the lack of some property."""
    if isinstance(value, list):
        return [_with_kinds_first(item) for item in value]
    if not isinstance(value, dict):
        return value
    value = {key: _with_kinds_first(member) for key, member in value.items()}
    conditions = [rule["if"] for rule in value.get("allOf", ()) if "if" in rule]
    kinds = {key for condition in conditions for key in condition.get("properties", {})}
    chosen = {key: value["properties"][key] for key in kinds & value.get("properties", {}).keys()}
    if chosen:
        required = [key for key in chosen if key in value.get("required", ())]
        value["allOf"] = [{"properties": chosen, "required": required}, *value["allOf"]]
    return value


def _readings(value: Any, name: str, parts: Place) -> Iterator[tuple[Place, Any]]:
    """Every place that the validator's name ``.objects[0].kappa`` may denote, because keys may
    contain dots, with its value."""
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
    """The faulty key, None for the value itself, and the reason."""
    rule, limit, value = error.rule, error.rule_definition, error.value
    match rule:
        case "required":
            missing = next(key for key in limit if key not in value)
            others = set(value) - error.definition.get("properties", {}).keys()
            # The kind of a shape is its "type", that of a signal its "signal".
            wanted = "type" if missing == "signal" and "type" in others else missing
            return missing, "is required" + meant(wanted, others, ": is {!r} meant to be it?")
        case "additionalProperties":
            known = error.definition.get("properties", {})
            key = next(key for key in value if key not in known)
            return key, f"unknown key{meant(key, known)}; known are " + ", ".join(known)
        case "type":
            wanted = limit if isinstance(limit, str) else " or ".join(limit)
            return (
                None,
                f"must be {'an' if wanted[0] in 'aio' else 'a'} {wanted}, got {_shown(value)}",
            )
        case "enum":
            return (
                None,
                f"must be {' or '.join(json.dumps(choice) for choice in limit)}, got "
                f"{_shown(value)}{meant(value, limit)}",
            )
        case "minimum" | "exclusiveMinimum" | "maximum" | "exclusiveMaximum":
            words = {
                "minimum": "at least",
                "exclusiveMinimum": "more than",
                "maximum": "at most",
                "exclusiveMaximum": "less than",
            }
            return None, f"must be {words[rule]} {limit:g}, got {_shown(value)}"
        case "minItems" | "maxItems" | "minLength" | "maxLength":
            least = "least" if rule[:3] == "min" else "most"
            parts = "items" if rule[3:] == "Items" else "characters"
            parts = parts if limit != 1 else parts[:-1]
            return None, f"must have at {least} {limit} {parts}, has {len(value)}"
        case "propertyNames":
            known = limit["enum"]
            key = next(key for key in value if key not in known)
            return key, f"does not belong here{meant(key, known)}; known are " + ", ".join(known)
        case "oneOf":
            return None, error.definition.get("description", error.message)
        case None:
            return None, "does not belong here"
        case _:
            return None, error.message


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, list):
        return "an array"
    text = (
        json.dumps(value, default=repr)
        if not isinstance(value, int) or abs(value) < 10**_LONGEST_VALUE
        else "a huge number"
    )
    return text if len(text) <= _LONGEST_VALUE else text[:_LONGEST_VALUE] + "..."
