"""Objects, contacts, sources and listeners as JSON values. Errors are `PlacedError`, which names
the place of the value in its document."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass, replace
from enum import Enum
from functools import cache, partial
from inspect import signature
from typing import Any, TypeVar

import numpy as np

from ...contacts.body_sizes import Size, size_of
from ...contacts.shapes import Shape, shape_from_dict
from ...declaration import declared, default_of
from ...forms import Form, JsonObject
from ...scene.device_mapping import ActuatorMapping
from ...scene.functions import FUNCTIONS, TRANSMISSIONS, ModulationFunction, function_from_dict
from ...scene.impact_rule import ImpactLimits, ImpactRule
from ...scene.joint import Joint
from ...scene.materials import preset_named
from ...scene.measured import function_of
from ...scene.references import Place, PlacedError, meant
from ...scene.rule_table import Rule, RuleTable, Side
from ...scene.rules import ContactSettings
from ...scene.skeleton import part_in
from ...scene.texture import Texture
from ...scene.values import Contact, HapticObject, HapticScene, Listener, Pose, Source, Trigger
from ...signals import Signal, impact_material, signal_from_dict

T = TypeVar("T")


def read_value(make: Callable[..., T], form: Form, place: Place) -> T:
    """``make`` with the members of ``form`` as arguments."""
    known, required = _arguments(make)
    if not required <= form.keys() <= known:
        for key in sorted(form.keys() - known):
            raise PlacedError((*place, key), f"does not belong here{meant(key, known)}")
        for key in sorted(required - form.keys()):
            raise PlacedError((*place, key), "is required")
    members = read_members(form, place)
    return _placed(lambda _: make(**members), form, place)


def read_members(form: Form, place: Place) -> JsonObject:
    """The members of an item as arguments of its class: some converted by `_READERS`, other lists
    as tuples."""
    members = {
        key: _READERS[key](value, (*place, key)) if key in _READERS else value
        for key, value in form.items()
    }
    return {
        key: tuple(value) if isinstance(value, list) else value for key, value in members.items()
    }


@cache
def _arguments(make: Callable[..., Any]) -> tuple[frozenset[str], frozenset[str]]:
    """Names of the arguments of a function or class, and of those that have no default."""
    arguments = signature(make).parameters.values()
    return frozenset(one.name for one in arguments), frozenset(
        one.name for one in arguments if one.default is one.empty
    )


read_contact = partial(read_value, Contact)
read_source = partial(read_value, Source)
read_listener = partial(read_value, Listener)
read_rules = partial(read_value, ContactSettings)


def read_object(form: Form, place: Place) -> HapticObject:
    """An object. One that names a material of the library has what *Make Haptic* gives, unless it
    says otherwise: the material's κ and ρ, its measured function by the sizes of the shape, of a
    metre without one, and its impacts."""
    material = preset_named(form.get("material", ""))
    if material is None:
        return read_value(HapticObject, form, place)
    given = {
        "kappa": material.kappa,
        "rho": material.rho,
        "impact_material": impact_material(material.name) or "",
    }
    item = read_value(HapticObject, {**given, **form}, place)
    if "propagation" in form:
        return item
    size = Size.of_box((1.0, 1.0, 1.0)) if item.shape is None else size_of(item.shape)
    part = part_in(item.name) if material.name == "flesh" else ""
    made = function_of(material.name, size.edges, part=part, volume=size.volume)
    return replace(item, propagation=made)


def read_function(
    form: Form,
    place: Place,
    functions: Mapping[str, type[ModulationFunction]] = FUNCTIONS,
) -> ModulationFunction:
    """A propagation function, or another one of ``functions``."""
    return _placed(partial(function_from_dict, functions=functions), form, place)


def _placed(make: Callable[[Any], T], form: Form, place: Place) -> T:
    """Call ``make`` with a form. Its ValueError "key: reason" or "key/key: reason" becomes a
    `PlacedError` at that key of the form, which is at ``place`` in the document."""
    try:
        return make(form)
    except PlacedError:
        raise
    except ValueError as error:
        keys, _, reason = str(error).partition(": ")
        parts = keys.removeprefix("/").split("/")
        raise PlacedError((*place, *parts) if parts[0] in form else place, reason or keys) from None


_read_signal = partial(_placed, signal_from_dict)


def _read_template(form: Any, place: Place) -> Any:
    """A signal, or the name of predefined ones."""
    return form if isinstance(form, str) else _read_signal(form, place)


def _read_normal(vector: Sequence[float], place: Place) -> Sequence[float]:
    """A direction, normalised."""
    length = math.hypot(*vector)
    if length < 1e-12:
        raise PlacedError(place, "a vector of length 0 has no direction")
    return vector if abs(length - 1) <= 1e-6 else [component / length for component in vector]


def read_list(read: Callable[[Any, Place], T], forms: Sequence[Any], place: Place) -> tuple[T, ...]:
    """The items of a list, each read at its place."""
    return tuple(read(form, (*place, i)) for i, form in enumerate(forms))


def read_items(
    form: Form, key: str, read: Callable[[Any, Place], T], place: Place = ()
) -> tuple[T, ...]:
    """The items of the list ``key`` of an object; none where it is absent."""
    return read_list(read, form.get(key, ()), (*place, key))


read_triggers = partial(read_list, partial(read_value, Trigger))


def _read_table(make: Callable[..., T], forms: Sequence[Form], place: Place) -> RuleTable[T]:
    """A table of rules; ``make`` makes the value of a row from its keys other than ``between``,
    which has none, one or both sides."""
    rows = []
    for i, form in enumerate(forms):
        sides = [
            read_value(Side, side, (*place, i, "between", k))
            for k, side in enumerate(form.get("between", []))
        ]
        first, second = (*sides, Side(), Side())[:2]
        does = {key: value for key, value in form.items() if key != "between"}
        rows.append(Rule((first, second), read_value(make, does, (*place, i))))
    return RuleTable(tuple(rows))


_READERS: Mapping[str, Callable[[Any, Place], Any]] = {
    "actuators": partial(read_list, partial(read_value, ActuatorMapping)),
    "impact_table": partial(_read_table, ImpactRule),
    "joints": partial(read_list, partial(read_value, Joint)),
    "limits": partial(read_value, ImpactLimits),
    "normal": _read_normal,
    "passing": lambda pairs, _: tuple(map(tuple, pairs)),
    "pose": partial(read_value, Pose),
    "propagation": read_function,
    "shape": partial(_placed, shape_from_dict),
    "signal": _read_signal,
    "template": _read_template,
    "textures": partial(_read_table, Texture),
    "transmission": partial(read_function, functions=TRANSMISSIONS),
    "transmission_table": partial(_read_table, lambda transmission: transmission),
    "triggers": read_triggers,
}
"""Readers of the members of items, by the name of the member, which means the same in every
item."""


def item_to_dict(item: Any) -> JsonObject:
    """The JSON object of an item: required values, and others where they differ from their
    default."""
    values = (
        (name, getattr(item, name), default) for name, default in _defaults(item.__class__).items()
    )
    return {
        name: json_value(value)
        for name, value, default in values
        if value != default or (name in _OF_MATERIAL and item.material)
    }


_OF_MATERIAL = ("propagation", "impact_material")
"""Members of an object that follow from its material where they are left out."""


@cache
def _defaults(cls: type) -> Form:
    """The defaults of the fields of a class, `MISSING` for a field that is always written."""
    required = {name for name, declaration in declared(cls).items() if declaration.required}
    return {
        entry.name: MISSING if entry.name in required else default_of(cls, entry.name)
        for entry in fields(cls)
    }


def _rule_value_to_dict(does: ImpactRule | ModulationFunction | Texture) -> JsonObject:
    return (
        {"transmission": does.to_dict()}
        if isinstance(does, ModulationFunction)
        else item_to_dict(does)
    )


def scene_items(scene: HapticScene) -> dict[str, list[JsonObject]]:
    """The JSON lists of a scene."""
    return {
        key: [item_to_dict(item) for item in getattr(scene, key)]
        for key in ("objects", "contacts", "sources", "listeners")
    }


def json_value(value: Any) -> Any:
    """A value of a scene in the types that JSON has. Raises TypeError for others."""
    match value:
        case Enum():
            return value.value
        case None | bool() | float() | int() | str():
            return value
        case Pose():
            return {"position": list(value.position), "rotation": list(value.rotation)}
        case ModulationFunction() | Shape() | Signal():
            return value.to_dict()
        case RuleTable():
            return [
                {
                    "between": [item_to_dict(side) for side in row.between],
                    **_rule_value_to_dict(row.value),
                }
                for row in value.rows
            ]
        case Mapping():
            return {key: json_value(member) for key, member in value.items()}
        case list() | tuple():
            return [json_value(member) for member in value]
        case np.generic() | np.ndarray():
            return value.tolist()
        case _ if is_dataclass(value):
            return item_to_dict(value)
        case _:
            raise TypeError(f"{type(value).__name__} has no form in a scene file")
