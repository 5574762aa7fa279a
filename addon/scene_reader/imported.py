"""Values of an imported file that Blender's properties cannot hold, stored as JSON in the .blend.

The text may come from an untrusted .blend file: `stored` validates it against ``stored.schema.json``, which uses the definitions of the
scene file's schema.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, cast

from ...core.contacts.shapes import Shape, shape_from_dict
from ...core.formats.io.scene_schema import DEFINED, SCENE
from ...core.formats.io.schema import load_schema, validate
from ...core.formats.io.strict_json import parse_json
from ...core.formats.scene.recording import by_pair, pair_of
from ...core.formats.scene.scene_json import FORMAT, VERSION, scene_from_dict
from ...core.formats.scene.values_json import item_to_dict, read_members, read_triggers
from ...core.scene.declaration import declared
from ...core.scene.functions import Identity, ModulationFunction, function_from_dict
from ...core.scene.rules import Motion
from ...core.scene.values import Contact, Pose, SourceKind, Trigger, Vector
from ...core.signals import Signal, signal_from_dict
from ..blender.single_precision import authored, shortest
from ..properties.declared import held_as, value_of

RULES = {
    "contact_tolerance": "tolerance",
    "minimum_energy": "least_energy",
    "maximum_energy": "full_energy",
    "refractory_time": "refractory",
}
"""Numbers of `ContactSettings` by the properties of a scene that hold them."""

OF_PROPAGATION = ("threshold", "epsilon", "localise")
"""Numbers of `Settings`, which have the same names in a scene's properties."""
OF_IMPACTS, LIMITS = ("bend", "variation"), ("least_energy", "full_energy", "refractory")
"""Numbers of a rule for impacts and of its limits, which have the same names in properties and in the core."""

NEAR = 1e-5
"""Difference in metres, or in elements of a rotation, below which an object counts as unmoved since the import, because Blender rounds to
single precision."""

Numbers = Mapping[str, float]
"""Numbers of the file in double precision, by property."""
Pair = tuple[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Imported:
    """Values of an object, source, listener, rule, device or scene; those that its text does not hold are None or empty.

    ``numbers`` with more digits than the properties hold, and ``extras``, keys of the file that this version does not know. The
    ``function`` of an object applies while its properties represent it, the ``signal`` of a source or rule while its choice is the imported
    signal. ``emitters``: positions of sources of other modalities on an object, by modality. ``tolerance`` of sums over paths, ``slack`` of
    contacts.
    """

    numbers: Numbers = field(default_factory=dict)
    extras: Mapping[str, Any] = field(default_factory=dict)
    shape: Shape | None = None
    mass: float | None = None
    pose: Pose | None = None
    function: ModulationFunction | None = None
    emitters: Mapping[str, Vector] = field(default_factory=dict)
    motion: Motion | None = None
    impact_material: str = ""
    signal: Signal | None = None
    kind: SourceKind = SourceKind.PERSISTENT
    onset: float = 0.0
    second_object: str | None = None
    second_position: Vector | None = None
    position: Vector | None = None
    triggers: tuple[Trigger, ...] = ()
    tolerance: float | None = None
    slack: float | None = None
    profile: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class FileContacts:
    """Contacts of a scene. ``contacts`` by their objects in alphabetical order, valid while neither has moved and the contact tolerance is
    ``tolerance`` [m]; ``transmissions``: functions of all contacts of the two objects."""

    contacts: Mapping[Pair, tuple[Contact, ...]] = field(default_factory=dict)
    transmissions: Mapping[Pair, ModulationFunction] = field(default_factory=dict)
    tolerance: float = 0.0


def text_of(**parts: Any) -> str:
    """The text that stores ``parts``, "" if there are none."""
    used = {key: value for key, value in parts.items() if value not in (None, {}, [])}
    return json.dumps(used, ensure_ascii=False, allow_nan=False, separators=(",", ":")) if used else ""


def text_of_contacts(contacts: Iterable[Contact], later: Iterable[Contact], tolerance: float) -> str:
    """The text for `file_contacts`; ``later``: contacts that begin in later frames, for their functions."""
    forms = [[item_to_dict(item) for item in items] for items in (contacts, later)]
    if not any(forms):
        return ""
    return text_of(contacts=forms[0], later=forms[1], tolerance=tolerance)


def exact(owner: Any, name: str, numbers: Numbers) -> Any:
    """A property's value with the author's precision: the imported number if there is one, otherwise as `authored`. Editing the property
    removes the number; for an animated property it is used only in frames in which both agree."""
    number = numbers.get(name)
    if number is not None and owner.id_data.animation_data is None:
        return number
    value = authored(getattr(owner, name))
    return number if number is not None and shortest(number) == value else value


@lru_cache(maxsize=8192)
def stored_item(text: str, name: str) -> Mapping[str, Any]:
    """The fields of the item in a text, without its name and its references; ``name``: that of its definition in the schema of scenes.

    Raises ValueError if the text is damaged.
    """
    if not text:
        return {}
    with _damaged():
        form = parse_json(text.encode("utf-8", "surrogatepass"), "imported")
        if isinstance(form, dict) and isinstance(form.get("numbers"), dict):  # until version 0.1 these were apart
            form |= form.pop("numbers")
        validate(form, f"{SCENE}#{name}", "imported")
        return read_members({key: value for key, value in form.items() if key in declared(DEFINED[name])}, ())


def read_values(cls: type, group: Any, stored: Mapping[str, Any]) -> dict[str, Any]:
    """The values of the fields of ``cls`` that the properties of ``group`` hold, and those ``stored`` of the others. A stored value counts
    as long as its property holds it, which may be with fewer digits."""
    values = dict(stored)
    for key, name in group.held[cls].items():
        held = getattr(group, name)
        held = tuple(held) if hasattr(held, "foreach_get") else held
        if key not in stored or held_as(cls, key, stored[key]) != held:
            values[key] = value_of(cls, key, held)
    return values


def text_with(text: str, emitters: Mapping[str, Vector], numbers: Numbers) -> str:
    """The text of an object with further emitters and numbers."""
    form = stored(text, "object")
    return text_of(**{**form, "emitters": {**form.get("emitters", {}), **emitters}, "numbers": {**form.get("numbers", {}), **numbers}})


def _reader(kind: str, kept: int) -> Callable[[str], Imported]:
    """The function from a stored text to what it stores, with a cache of ``kept`` results. It raises ValueError for a damaged text."""
    return lru_cache(maxsize=kept)(lambda text: _imported(text, kind))


imported_object = _reader("object", 4096)
imported_source = _reader("source", 4096)
imported_scene = _reader("scene", 8)
imported_rule = _reader("rule", 1024)
imported_device = _reader("device", 64)


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
            transmissions={pair_of(item): item.transmission for item in reversed((*found, *later)) if item.transmission != Identity()},
            tolerance=float(form.get("tolerance", 0.0)),
        )


def near(kept: Vector, position: Vector) -> bool:
    """Whether a position equals the stored one up to rounding."""
    return math.dist(kept, position) <= NEAR * max(1.0, *map(abs, kept))


def _contacts(forms: Any) -> tuple[Contact, ...]:
    """Contacts, validated as in a scene file."""
    names = {name for form in forms for name in form["objects"]}
    objects = [{"name": name, "kappa": 0, "rho": 0} for name in names]
    return scene_from_dict({"format": FORMAT, "version": VERSION, "objects": objects, "contacts": forms}, "imported").contacts


def _imported(text: str, kind: str) -> Imported:
    """What a text stores; keys of a later version of the add-on are ignored."""
    form = stored(text, kind)
    with _damaged():
        known = {key: value for key, value in form.items() if key in _schema()["$defs"][kind]["properties"]}
        return Imported(**{key: _READERS.get(key, plain)(value) for key, value in known.items()})


def plain(value: Any) -> Any:
    """A JSON value with its numbers as floats and its lists as tuples."""
    match value:
        case int():
            return float(value)
        case list():
            return tuple(map(plain, value))
        case dict():
            return {key: plain(member) for key, member in value.items()}
    return value


_READERS: Mapping[str, Callable[[Any], Any]] = {
    "extras": dict,
    "shape": shape_from_dict,
    "pose": lambda form: Pose(tuple(form["position"]), tuple(form["rotation"])),
    "function": function_from_dict,
    "motion": Motion,
    "signal": signal_from_dict,
    "kind": SourceKind,
    "triggers": lambda forms: read_triggers(forms, ()),
}
"""Converters of stored values other than `plain`, by key."""


@cache
def _schema() -> Any:
    return json.loads(Path(__file__).with_name("stored.schema.json").read_text("utf-8"))


@cache
def _validator(kind: str) -> Callable[[Any], Any]:
    import fastjsonschema

    schema = _schema()
    definition = {key: schema[key] for key in ("$schema", "$id")} | schema["$defs"][kind]
    handlers = {"https": lambda uri: load_schema(uri.rpartition("/")[2].removesuffix(".schema.json"))}
    validate: Callable[[Any], Any] = fastjsonschema.compile(definition, handlers, use_default=False)
    return validate


def stored(text: str, kind: str) -> dict[str, Any]:
    """The document that a property stores; an empty one for no text. Raises ValueError if it is invalid."""
    if not text:
        return {}
    import fastjsonschema

    with _damaged():
        document: Any = parse_json(text.encode("utf-8", "surrogatepass"), "imported")
        try:
            _validator(kind)(document)
        except fastjsonschema.JsonSchemaValueException as error:
            raise ValueError(
                f"{'/'.join(map(str, error.path[1:])) or 'it'} {error.message.removeprefix(error.name or '').strip()}"
            ) from None
    return cast(dict[str, Any], document)


@contextmanager
def _damaged() -> Iterator[None]:
    """Turn an error of a stored document into a message with the remedy."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"what was imported with it is damaged: import it again ({error})") from None
