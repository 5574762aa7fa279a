"""Values of an imported file that Blender's properties cannot hold, stored as JSON in the .blend.

The text may come from an untrusted .blend file: `stored` validates it against
``stored.schema.json``, which uses the definitions of the scene file's schema.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import field
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, cast

from ...core.declaration import declared
from ...core.formats.io.scene_schema import DEFINED, SCENE
from ...core.formats.io.schema import load_schema, validate
from ...core.formats.io.strict_json import parse_json
from ...core.formats.scene.recording import by_pair, pair_of
from ...core.formats.scene.scene_json import FORMAT, VERSION, scene_from_dict
from ...core.formats.scene.values_json import item_to_dict, read_members
from ...core.forms import Form, JsonObject
from ...core.frozen import frozen
from ...core.scene.functions import Identity, ModulationFunction
from ...core.scene.impact_rule import ImpactLimits
from ...core.scene.rules import ContactSettings
from ...core.scene.values import Contact, Settings, Vector
from ..properties.scene import HapticSceneProperties

NEAR = 1e-5
"""Difference in metres, or in elements of a rotation, below which an object counts as unmoved since
the import, because Blender rounds to single precision."""

Pair = tuple[str, str]


@frozen(eq=False)
class FileContacts:
    """Contacts of a scene. ``contacts`` by their objects in alphabetical order, valid while neither
    has moved and the contact tolerance is ``tolerance`` [m]; ``transmissions``: functions of all
    contacts of the two objects."""

    contacts: Mapping[Pair, tuple[Contact, ...]] = field(default_factory=dict)
    transmissions: Mapping[Pair, ModulationFunction] = field(default_factory=dict)
    tolerance: float = 0.0


def text_of(**parts: Any) -> str:
    """The text that stores ``parts``, "" if there are none."""
    used = {key: value for key, value in parts.items() if value not in (None, {}, [])}
    return (
        json.dumps(used, ensure_ascii=False, allow_nan=False, separators=(",", ":")) if used else ""
    )


def text_of_contacts(
    contacts: Iterable[Contact], later: Iterable[Contact], tolerance: float
) -> str:
    """The text that `file_contacts` reads. Of the contacts that begin in ``later`` frames only the
    transmission functions count; ``tolerance`` [m]: of contacts in the file."""
    forms = [[item_to_dict(item) for item in items] for items in (contacts, later)]
    if not any(forms):
        return ""
    return text_of(contacts=forms[0], later=forms[1], tolerance=tolerance)


@lru_cache(maxsize=8192)
def stored_item(text: str, name: str) -> Form:
    """The stored fields of an item, as values of the core, without its name and the names of other
    objects, which are those of Blender's objects.

    Args:
        text: of the property ``imported``, JSON.
        name: of the item's definition in the schema of scenes, such as "source".

    Raises:
        ValueError: if the text is damaged.
    """
    if not text:
        return {}
    with _damaged():
        form = _in_terms_of_files(
            parse_json(text.encode("utf-8", "surrogatepass"), "imported"), name
        )
        validate(form, f"{SCENE}#{name}", "imported")
        return read_members(
            {key: value for key, value in form.items() if key in declared(DEFINED[name])}, ()
        )


def _in_terms_of_files(form: Any, name: str) -> Any:
    """The item ``name`` of a stored document in the form of today's scene files. Version 0.1 stored
    only what properties could not hold, and numbers apart from the rest."""
    if not isinstance(form, dict):
        return form
    numbers = form.get("numbers")
    numbers = numbers if isinstance(numbers, dict) else {}
    match name:
        case "settings":
            return form.get(
                name,
                {
                    key: value
                    for key, value in {**form, **numbers}.items()
                    if key in declared(Settings)
                },
            )
        case "rules":
            held = HapticSceneProperties.held[ContactSettings].items()
            former = {key: numbers[own] for key, own in held if own in numbers}
            return form.get(
                name, {**former, **({"slack": form["slack"]} if "slack" in form else {})}
            )
        case "impact_rule":
            limits = {key: numbers.pop(key) for key in declared(ImpactLimits) if key in numbers}
            form = {"template": form["signal"], **form} if "signal" in form else form
            return {**form, **({"limits": limits} if limits else {}), **numbers}
        case "object" if "function" in form:
            form = {**form, "propagation": form["function"]}
    return {**form, **{key: value for key, value in numbers.items() if "." not in key}}


def stored_extras(text: str) -> Form:
    """The stored extras of a scene."""
    extras: Form = stored(text, "scene").get("extras", {})
    return extras


def fields_of(item: Any) -> JsonObject:
    """The values of the declared fields of an item, {} for None."""
    return {} if item is None else {key: getattr(item, key) for key in declared(item.__class__)}


@lru_cache(maxsize=8)
def file_contacts(text: str) -> FileContacts:
    """The stored contacts. Raises ValueError if the text is damaged."""
    form = stored(text, "contacts")
    if not form:
        return FileContacts()
    with _damaged():
        found, later = (_contacts(form.get(key, [])) for key in ("contacts", "later"))
        return FileContacts(
            contacts=by_pair(found),
            transmissions={
                pair_of(item): item.transmission
                for item in reversed((*found, *later))
                if item.transmission != Identity()
            },
            tolerance=float(form.get("tolerance", 0.0)),
        )


def near(kept: Vector, position: Vector) -> bool:
    """Whether a position equals the stored one up to rounding."""
    return math.dist(kept, position) <= NEAR * max(1.0, *map(abs, kept))


def _contacts(forms: Any) -> tuple[Contact, ...]:
    """Contacts, validated as in a scene file."""
    names = {name for form in forms for name in form["objects"]}
    objects = [{"name": name, "kappa": 0, "rho": 0} for name in names]
    return scene_from_dict(
        {"format": FORMAT, "version": VERSION, "objects": objects, "contacts": forms}, "imported"
    ).contacts


def with_floats(value: Any) -> Any:
    """A JSON value with floats for integers and tuples for lists, at any depth."""
    match value:
        case int():
            return float(value)
        case list():
            return tuple(map(with_floats, value))
        case dict():
            return {key: with_floats(member) for key, member in value.items()}
    return value


@cache
def _schema() -> Any:
    return json.loads(Path(__file__).with_name("stored.schema.json").read_text("utf-8"))


@cache
def _validator(kind: str) -> Callable[[Any], Any]:
    import fastjsonschema

    schema = _schema()
    definition = {key: schema[key] for key in ("$schema", "$id")} | schema["$defs"][kind]
    handlers = {
        "https": lambda uri: load_schema(uri.rpartition("/")[2].removesuffix(".schema.json"))
    }
    validate: Callable[[Any], Any] = fastjsonschema.compile(definition, handlers, use_default=False)
    return validate


def stored(text: str, kind: str) -> JsonObject:
    """The document that a property stores; an empty one for no text. Raises ValueError if it is
    invalid."""
    if not text:
        return {}
    import fastjsonschema

    with _damaged():
        document: Any = parse_json(text.encode("utf-8", "surrogatepass"), "imported")
        try:
            _validator(kind)(document)
        except fastjsonschema.JsonSchemaValueException as error:
            raise ValueError(
                f"{'/'.join(map(str, error.path[1:])) or 'it'} "
                f"{error.message.removeprefix(error.name or '').strip()}"
            ) from None
    return cast(JsonObject, document)


@contextmanager
def _damaged() -> Iterator[None]:
    """Turn an error of a stored document into a message with the remedy."""
    try:
        yield
    except ValueError as error:
        raise ValueError(
            f"what was imported with it is damaged: import it again ({error})"
        ) from None
