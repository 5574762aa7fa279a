"""The schema of haptic scenes says what each property means, its examples are scenes, and its page
is that of today's schema."""

import importlib.util
import json
from pathlib import Path

import jsonschema
import pytest
from haptic_tracing.core.formats.io.schema import SCHEMAS, load_schema
from haptic_tracing.core.formats.scene.scene_json import CONVENTION, scene_from_dict
from haptic_tracing.core.scene.rules import ContactSettings, ImpactEnergy, ImpactTemplates, Motion
from haptic_tracing.core.signals import IMPACT_MATERIALS

ROOT = Path(__file__).parents[3]
SCHEMA = load_schema("haptic-scene-1.1")
CONDITIONS = {"if", "then", "else", "allOf"}


def properties(value, path=()):
    """(path, definition) of every property that is defined; conditions only restrict what is
    defined elsewhere."""
    if isinstance(value, dict):
        for key, member in value.items():
            if key == "properties":
                for name, definition in member.items():
                    yield (*path, name), definition
                    yield from properties(definition, (*path, name))
            elif key not in CONDITIONS:
                yield from properties(member, (*path, key))


def test_every_property_is_described():
    found = dict(properties(SCHEMA))
    assert len(found) > 180
    undescribed = [
        "/".join(path)
        for path, definition in found.items()
        if len(definition.get("description", "")) < 6
    ]
    assert undescribed == []


def test_a_property_without_a_description_is_found():
    schema = {
        "properties": {
            "a": {
                "type": "object",
                "description": "Something.",
                "properties": {"b": {"type": "number"}},
            }
        }
    }
    assert [path for path, definition in properties(schema) if "description" not in definition] == [
        ("a", "b")
    ]


def test_the_examples_are_valid():
    (document,) = SCHEMA["examples"]
    jsonschema.Draft202012Validator(SCHEMA).validate(document)
    assert scene_from_dict(document, "example").sources[0].name == "drill"
    names = [name for name, definition in SCHEMA["$defs"].items() if "examples" in definition]
    assert {"object", "contact", "source", "listener", "rules", "frame"} <= set(names)
    for name in names:
        validator = jsonschema.Draft202012Validator(
            {"$ref": f"#/$defs/{name}", "$defs": SCHEMA["$defs"]}
        )
        for example in SCHEMA["$defs"][name]["examples"]:
            validator.validate(example)


def test_choices_are_those_of_the_core():
    rules, item = SCHEMA["$defs"]["rules"]["properties"], SCHEMA["$defs"]["object"]["properties"]
    assert set(rules) == set(ContactSettings.__dataclass_fields__)
    assert rules["energy"]["enum"] == list(ImpactEnergy) and set(rules["templates"]["enum"]) == set(
        ImpactTemplates
    )
    assert item["motion"]["enum"] == list(Motion) and SCHEMA["$defs"]["impact_material"][
        "enum"
    ] == ["", *IMPACT_MATERIALS]
    assert {
        key: value["const"]
        for key, value in SCHEMA["properties"]["convention"]["properties"].items()
    } == CONVENTION


@pytest.mark.parametrize("path", sorted(SCHEMAS.glob("*.json")), ids=lambda path: path.name)
def test_every_schema_has_an_address(path):
    assert (
        json.loads(path.read_text("utf-8"))["$id"]
        == f"https://haptic-tracing.org/schemas/{path.name}"
    )


@pytest.mark.plugins
def test_the_published_schema_its_page_and_the_table_of_formats_are_those_of_the_core():
    spec = importlib.util.spec_from_file_location(
        "write_schema_page", ROOT / "docs" / "write_schema_page.py"
    )
    writer = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(writer)
    assert (ROOT / "docs" / "schema.md").read_text("utf-8") == writer.page(), (
        "run python docs/write_schema_page.py"
    )
    formats = (ROOT / "docs" / "formats.md").read_text("utf-8")
    assert formats == writer.formats(formats), "run python docs/write_schema_page.py"
    assert (ROOT / "docs" / writer.NAME).read_text("utf-8") == writer.document(), (
        "run python docs/write_schema_page.py"
    )
