"""Writes the schema of haptic scenes, from it docs/schema.md (every property with its values and
what it means), and the table of formats.

python docs/write_schema_page.py      (part of `make docs`)
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from haptic_tracing.core.formats.io.catalogue import formats as known_formats
from haptic_tracing.core.formats.io.scene_schema import scene_schema

HERE = Path(__file__).resolve().parent
NAME = "haptic-scene-1.1.schema.json"
HEAD = f"""# Haptic scene, property by property

Made, like the [JSON Schema]({NAME}), from the declarations of the fields by `docs/write_schema_page.py`. What the parts are for is said in
[Formats](formats.md). Axes are right-handed with z up; lengths in metres, masses in kilograms, times in seconds, energies in joules.
"""


def document() -> str:
    """The JSON Schema."""
    return json.dumps(scene_schema(), indent=1, ensure_ascii=False) + "\n"


def page() -> str:
    """The page as Markdown."""
    schema = scene_schema()
    parts = [HEAD, *_section("document", schema, schema["$defs"], "The file")]
    for name, definition in schema["$defs"].items():
        if "properties" in definition:
            parts += _section(name, definition, schema["$defs"], f"`{name}`")
    return "\n".join(parts)


def formats(text: str) -> str:
    """The page of formats with a table of the catalogue's."""
    head = "| name | written | read | carries |\n|---|---|---|---|\n"
    before, after = text.split(head)
    rows = (
        f"| `{form.name}` | {', '.join(f'`{name}`' for name in form.files.split())} | "
        f"{'yes' if form.is_read else ''} | {form.carries} |\n"
        for form in known_formats().values()
    )
    return before + head + "".join(rows) + "\n" + after.split("\n\n", 1)[1]


def _section(
    name: str, definition: dict[str, Any], defined: dict[str, Any], title: str
) -> Iterator[str]:
    yield f"## {title}\n"
    if "description" in definition:
        yield definition["description"] + "\n"
    yield "| property | values | meaning |\n|---|---|---|"
    required = definition.get("required", [])
    for key, value in definition["properties"].items():
        meaning = value.get("description", "") + (" **Required.**" if key in required else "")
        yield f"| `{key}` | {_values(value, defined)} | {_cell(meaning.strip())} |"
    yield ""
    for example in definition.get("examples", []):
        yield f"```json\n{json.dumps(example)}\n```\n"


def _values(value: dict[str, Any], defined: dict[str, Any]) -> str:
    """Type and range."""
    if "allOf" in value:
        return _values(value["allOf"][0], defined)
    if "$ref" in value:
        name = value["$ref"].rsplit("/", 1)[-1]
        target = defined[name]
        return f"[{name}](#{name})" if "properties" in target else _values(target, defined)
    if "const" in value:
        return f"`{json.dumps(value['const'])}`"
    if "enum" in value:
        return ", ".join(f"`{json.dumps(choice)}`" for choice in value["enum"])
    kinds = [value["type"]] if isinstance(value.get("type"), str) else value.get("type", ["object"])
    words = " or ".join(kinds)
    if "array" in kinds and "items" in value:
        counts = _range(value.get("minItems"), value.get("maxItems"))
        words = words.replace(
            "array", f"array of {counts} {_values(value['items'], defined)}".replace("  ", " ")
        )
    others = value.get("additionalProperties")
    if isinstance(others, dict) and others != {"$ref": "#/$defs/json"}:
        words += f" of {_values(others, defined)}"
    if {"number", "integer"} & set(kinds):
        words += _bounds(value)
    if "string" in kinds and "maxLength" in value:
        words += f", at most {value['maxLength']:,} characters"
    return words


def _range(least: int | None, most: int | None) -> str:
    if least == most:
        return "" if least is None else f"{least:,}"
    return f"{least:,} to {most:,}" if least and most else f"up to {most:,}" if most else ""


def _bounds(value: dict[str, Any]) -> str:
    low, high = value.get("minimum", value.get("exclusiveMinimum")), value.get("maximum")
    form = ",d" if value["type"] == "integer" else ",g"
    words = ""
    if low is not None:
        words += f" {'above' if 'exclusiveMinimum' in value else 'from'} {low:{form}}"
    return words + (f" to {high:{form}}" if high is not None else "")


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


if __name__ == "__main__":
    (HERE / NAME).write_text(document(), "utf-8")
    (HERE / "schema.md").write_text(page(), "utf-8")
    page_of_formats = HERE / "formats.md"
    page_of_formats.write_text(formats(page_of_formats.read_text("utf-8")), "utf-8")
