"""Objects, contacts, sources and listeners as JSON values. Errors are PlacedErrors: they name the place of the value in its document."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, fields
from enum import Enum
from functools import partial
from typing import Any, TypeVar

import numpy as np

from ...contacts.shapes import Shape, shape_from_dict
from ...scene.functions import FUNCTIONS, TRANSMISSIONS, ModulationFunction, function_from_dict
from ...scene.impact_rule import ImpactLimits, ImpactRule
from ...scene.references import Place, PlacedError
from ...scene.rule_table import Rule, RuleTable, Side
from ...scene.rules import ContactSettings
from ...scene.texture import Texture
from ...scene.values import Contact, HapticObject, HapticScene, Listener, Pose, Source, Trigger
from ...signals import Signal, signal_from_dict

T = TypeVar("T")


def read_value(make: Callable[..., T], form: Mapping[str, Any], place: Place) -> T:
    """``make`` with the members of ``form`` as arguments, lists as tuples."""
    return _placed(lambda: make(**{key: tuple(v) if isinstance(v, list) else v for key, v in form.items()}), form, place)


def read_function(
    form: Mapping[str, Any], place: Place, functions: Mapping[str, type[ModulationFunction]] = FUNCTIONS
) -> ModulationFunction:
    """A propagation function, or another one of ``functions``."""
    return _placed(lambda: function_from_dict(form, functions), form, place)


def _members(form: Mapping[str, Any], place: Place, **readers: Callable[[Any, Place], Any]) -> dict[str, Any]:
    """The members of ``form``, converted by their readers if they have one."""
    return {key: readers[key](value, (*place, key)) if key in readers else value for key, value in form.items()}


def _read_signal(form: Mapping[str, Any], place: Place) -> Signal:
    return _placed(lambda: signal_from_dict(form), form, place)


def _read_shape(form: Mapping[str, Any], place: Place) -> Shape:
    return _placed(lambda: shape_from_dict(form), form, place)


_read_pose = partial(read_value, Pose)
read_listener = partial(read_value, Listener)
_read_transmission = partial(read_function, functions=TRANSMISSIONS)


def read_object(form: Mapping[str, Any], place: Place) -> HapticObject:
    """An object with its function, pose and shape."""
    arguments = _members(form, place, propagation=read_function, pose=_read_pose, shape=_read_shape)
    if "material" not in form and isinstance(form.get("extras", {}).get("material"), str):  # where version 1.0 wrote it
        arguments["extras"] = dict(form["extras"])
        arguments["material"] = arguments["extras"].pop("material")
    return read_value(HapticObject, arguments, place)


def read_contact(form: Mapping[str, Any], place: Place) -> Contact:
    """A contact; its normal is normalised."""
    return read_value(Contact, _members(form, place, transmission=_read_transmission, normal=_read_normal), place)


def _read_normal(vector: Sequence[float], place: Place) -> Sequence[float]:
    length = math.hypot(*vector)
    if length < 1e-12:
        raise PlacedError(place, "a vector of length 0 has no direction")
    return vector if abs(length - 1) <= 1e-6 else [component / length for component in vector]


def read_source(form: Mapping[str, Any], place: Place) -> Source:
    """A source with its signal."""
    return read_value(Source, _members(form, place, signal=_read_signal, triggers=read_triggers), place)


def read_triggers(forms: Sequence[Mapping[str, Any]], place: Place) -> tuple[Trigger, ...]:
    """The triggers of a source."""
    return tuple(read_value(Trigger, _members(form, (*place, k), pose=_read_pose), (*place, k)) for k, form in enumerate(forms))


def read_rules(form: Mapping[str, Any], place: Place) -> ContactSettings:
    """The rules of contacts and impacts, with their tables."""
    impacts, textures = partial(read_table, read=_read_impact_rule), partial(read_table, read=partial(read_value, Texture))
    transmissions = partial(read_table, read=lambda row, own: _members(row, own, transmission=_read_transmission)["transmission"])
    members = _members(form, place, impact_table=impacts, transmission_table=transmissions, textures=textures)
    return read_value(ContactSettings, members, place)


def read_table(forms: Sequence[Mapping[str, Any]], place: Place, read: Callable[[Mapping[str, Any], Place], T]) -> RuleTable[T]:
    """A table of rules; ``read`` makes the value of a row from its keys other than ``between``, which has none, one or both sides."""
    rows = []
    for i, form in enumerate(forms):
        sides = [read_value(Side, side, (*place, i, "between", k)) for k, side in enumerate(form.get("between", []))]
        first, second = (*sides, Side(), Side())[:2]
        rows.append(Rule((first, second), read({key: value for key, value in form.items() if key != "between"}, (*place, i))))
    return RuleTable(tuple(rows))


def _read_impact_rule(form: Mapping[str, Any], place: Place) -> ImpactRule:
    return read_value(ImpactRule, _members(form, place, template=_read_template, limits=partial(read_value, ImpactLimits)), place)


def _read_template(value: Any, place: Place) -> Any:
    """A signal, or the name of predefined ones."""
    return _read_signal(value, place) if isinstance(value, dict) else value


def _placed(make: Callable[[], T], form: Mapping[str, Any], place: Place) -> T:
    """What ``make`` returns; its ValueError ``key: reason`` or ``key/key: reason`` becomes an error at that key of ``form``."""
    try:
        return make()
    except PlacedError:
        raise
    except ValueError as error:
        keys, _, reason = str(error).partition(": ")
        parts = keys.removeprefix("/").split("/")
        raise PlacedError((*place, *parts) if parts[0] in form else place, reason or keys) from None


def item_to_dict(item: Any) -> dict[str, Any]:
    """The JSON object of an item: positions always, other values where they differ from their default."""
    form: dict[str, Any] = {}
    for key in fields(item):
        value = getattr(item, key.name)
        default = key.default if key.default_factory is MISSING else key.default_factory()
        if value != default or key.name == "position":
            form[key.name] = json_value(value)
    return form


def _does_to_dict(does: ImpactRule | ModulationFunction | Texture) -> dict[str, Any]:
    return {"transmission": does.to_dict()} if isinstance(does, ModulationFunction) else item_to_dict(does)


def scene_items(scene: HapticScene) -> dict[str, list[dict[str, Any]]]:
    """The JSON lists of a scene."""
    return {key: [item_to_dict(item) for item in getattr(scene, key)] for key in ("objects", "contacts", "sources", "listeners")}


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
        case ImpactLimits() | Trigger():
            return item_to_dict(value)
        case RuleTable():
            return [{"between": [item_to_dict(side) for side in row.between], **_does_to_dict(row.does)} for row in value.rows]
        case Mapping():
            return {key: json_value(member) for key, member in value.items()}
        case list() | tuple():
            return [json_value(member) for member in value]
        case np.generic() | np.ndarray():
            return value.tolist()
        case _:
            raise TypeError(f"{type(value).__name__} has no form in a scene file")
