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


def read_object(form: Mapping[str, Any], place: Place) -> HapticObject:
    """An object with its function, pose and shape."""
    arguments = dict(form)
    if "material" not in form and isinstance(form.get("extras", {}).get("material"), str):  # where it was written at first
        arguments["extras"] = dict(form["extras"])
        arguments["material"] = arguments["extras"].pop("material")
    if "propagation" in form:
        arguments["propagation"] = read_function(form["propagation"], (*place, "propagation"))
    if "pose" in form:
        arguments["pose"] = read_value(Pose, form["pose"], (*place, "pose"))
    if "shape" in form:
        arguments["shape"] = _placed(lambda: shape_from_dict(form["shape"]), form["shape"], (*place, "shape"))
    return read_value(HapticObject, arguments, place)


def read_contact(form: Mapping[str, Any], place: Place) -> Contact:
    """A contact; its normal is normalised."""
    arguments = dict(form)
    if "transmission" in form:
        arguments["transmission"] = read_function(form["transmission"], (*place, "transmission"), TRANSMISSIONS)
    if "normal" in form:
        length = math.hypot(*form["normal"])
        if length < 1e-12:
            raise PlacedError((*place, "normal"), "a vector of length 0 has no direction")
        if abs(length - 1) > 1e-6:
            arguments["normal"] = tuple(component / length for component in form["normal"])
    return read_value(Contact, arguments, place)


def read_source(form: Mapping[str, Any], place: Place) -> Source:
    """A source with its signal."""
    arguments = dict(form)
    if "signal" in form:
        arguments["signal"] = _placed(lambda: signal_from_dict(form["signal"]), form["signal"], (*place, "signal"))
    if "triggers" in form:
        arguments["triggers"] = tuple(read_trigger(item, (*place, "triggers", k)) for k, item in enumerate(form["triggers"]))
    return read_value(Source, arguments, place)


def read_trigger(form: Mapping[str, Any], place: Place) -> Trigger:
    """What makes a source play once."""
    arguments = dict(form)
    if "pose" in form:
        arguments["pose"] = read_value(Pose, form["pose"], (*place, "pose"))
    return read_value(Trigger, arguments, place)


def read_rules(form: Mapping[str, Any], place: Place) -> ContactSettings:
    """The rules of contacts and impacts, with their tables."""
    arguments = dict(form)
    if "impact_table" in form:
        arguments["impact_table"] = read_table(form["impact_table"], (*place, "impact_table"), _read_impact_rule)
    if "transmission_table" in form:
        rows = form["transmission_table"]
        arguments["transmission_table"] = read_table(rows, (*place, "transmission_table"), _read_transmission)
    if "textures" in form:
        arguments["textures"] = read_table(form["textures"], (*place, "textures"), partial(read_value, Texture))
    return read_value(ContactSettings, arguments, place)


def read_table(forms: Sequence[Mapping[str, Any]], place: Place, read: Callable[[Mapping[str, Any], Place], T]) -> RuleTable[T]:
    """A table of rules; ``read`` makes what a row does from the keys beside ``between``, which has none, one or both sides."""
    rows = []
    for i, form in enumerate(forms):
        sides = [read_value(Side, side, (*place, i, "between", k)) for k, side in enumerate(form.get("between", []))]
        first, second = (*sides, Side(), Side())[:2]
        rows.append(Rule((first, second), read({key: value for key, value in form.items() if key != "between"}, (*place, i))))
    return RuleTable(tuple(rows))


def _read_transmission(form: Mapping[str, Any], place: Place) -> ModulationFunction:
    return read_function(form["transmission"], (*place, "transmission"), TRANSMISSIONS)


def _read_impact_rule(form: Mapping[str, Any], place: Place) -> ImpactRule:
    arguments = dict(form)
    if isinstance(form.get("template"), dict):
        arguments["template"] = _placed(lambda: signal_from_dict(form["template"]), form["template"], (*place, "template"))
    if "limits" in form:
        arguments["limits"] = read_value(ImpactLimits, form["limits"], (*place, "limits"))
    return read_value(ImpactRule, arguments, place)


def read_listener(form: Mapping[str, Any], place: Place) -> Listener:
    """A listener."""
    return read_value(Listener, form, place)


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
        case None | bool() | float() | int():
            return value
        case Enum():
            return value.value
        case str():
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
