"""Blender's properties of declared fields (`core.declaration`): their definitions, and what
they hold of a value."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from inspect import get_annotations
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    StringProperty,
)

from ...core.declaration import (
    Choice,
    Curve,
    Declaration,
    Number,
    Numbers,
    Switch,
    Text,
    declared,
    default_of,
    shown,
)
from ...core.forms import Form
from ..blender.single_precision import authored

_Group = TypeVar("_Group", bound=type)
_LEAST = float(np.finfo(np.float32).tiny)
"""The least number above 0 that a property holds."""
_NOTHING: Form = MappingProxyType({})
_IDENTIFIERS = {"": "NONE", "by_material": "MATERIALS", "plain": "PLAIN"}
"""Blender's identifiers of values that have others in the core."""


def holding(
    cls: type, *only: str, more: Mapping[str, Form] = _NOTHING, **names: str
) -> Callable[[_Group], _Group]:
    """Decorator: the group gets a property for each field of ``cls`` that has a label, after its
    own properties.

    Args:
        cls: A class with declared fields.
        only: The fields; all by default.
        more: Further arguments of Blender's properties, by field.
        names: Names of properties, by field, where they differ.
    """

    def decorate(group: _Group) -> _Group:
        fields = {key: item for key, item in shown(cls).items() if not only or key in only}
        held = {key: names.get(key, key) for key in fields}
        made = {
            held[key]: property_of(item, default_of(cls, key), more.get(key, _NOTHING))
            for key, item in fields.items()
        }
        group.__annotations__ = {**get_annotations(group), **made}
        inherited = {
            key: names
            for base in reversed(group.__mro__)
            for key, names in base.__dict__.get("held", {}).items()
        }
        group.held = {**inherited, cls: held}  # type: ignore[attr-defined]
        return group

    return decorate


def property_of(declaration: Declaration, default: Any = None, more: Form = _NOTHING) -> Any:
    """Blender's property for a declared field, with the field's ``shown`` default, else with
    ``default``. ``more``: further arguments of the property."""
    unit = getattr(declaration, "unit", "")
    default = default if declaration.shown is None else declaration.shown
    common: dict[str, Any] = {
        "name": f"{declaration.label} ({unit})".replace(") (", ", ") if unit else declaration.label,
        "description": declaration.about,
        "translation_context": declaration.context or "*",
        "default": default,
        **({} if declaration.animated else {"options": set()}),
        **more,
    }
    match declaration:
        case Switch():
            return BoolProperty(**common)
        case Choice():
            return EnumProperty(
                **{**common, "items": items_of(declaration.items), "default": identifier(default)}
            )
        case Numbers():
            return FloatVectorProperty(
                **{"size": declaration.count, **_limits(declaration), **common}
            )
        case Number(whole=True):
            return IntProperty(**{**_limits(declaration), **common})
        case Number():
            subtype = "FACTOR" if declaration.high == 1 else "NONE"
            return FloatProperty(
                **{
                    "subtype": subtype,
                    **_limits(declaration),
                    **common,
                }
            )
        case Curve():
            return StringProperty(**{**common, "default": declaration.text(default)})
    return StringProperty(**common)


def _limits(declaration: Number) -> dict[str, Any]:
    limits: dict[str, Any] = {
        "min": _LEAST
        if declaration.above and not declaration.low and not declaration.optional
        else declaration.low,
        "max": declaration.high,
    }
    if declaration.soft is not None:
        limits |= {"soft_min": declaration.soft[0], "soft_max": declaration.soft[1]}
    return limits if declaration.digits is None else {**limits, "precision": declaration.digits}


def items_of(items: Mapping[str, tuple[str, str]]) -> tuple[tuple[str, str, str, str, int], ...]:
    """The items of a choice, as Blender's properties have them."""
    return tuple(
        (identifier(value), *item, "", place) for place, (value, item) in enumerate(items.items())
    )


def identifier(value: str) -> str:
    """The identifier of a value in Blender."""
    return _IDENTIFIERS.get(value, str(value))


def _held_as(declaration: Declaration, value: Any) -> Any:
    """What a property holds of a value of a field, such as the nearest number; None for an unknown
    choice."""
    match declaration:
        case Choice():
            return identifier(value) if value in declaration.items else None
        case Numbers():
            return tuple(_nearest(declaration, number) for number in value)
        case Number(whole=True):
            return int(min(max(value or 0, declaration.low), declaration.high))
        case Number():
            return _nearest(declaration, value or 0.0)
        case Text():
            return value or declaration.shown or ""
        case Curve():
            return declaration.text(value)
    return value


def _nearest(declaration: Number, value: float) -> float:
    limits = _limits(declaration)
    return float(min(max(np.float32(value), np.float32(limits["min"])), np.float32(limits["max"])))


@cache
def _values_of(cls: type, key: str) -> dict[str, Any]:
    """The values of a choice by their identifiers."""
    return {identifier(value): value for value in declared(cls)[key].items}  # type: ignore[attr-defined]


def read_values(cls: type, group: Any) -> dict[str, Any]:
    """The values of the fields of ``cls`` that the properties of ``group`` hold."""
    values: dict[str, Any] = {}
    declarations = declared(cls)
    for key, name in group.held.get(cls, _NOTHING).items():
        declaration = declarations[key]
        held = getattr(group, name)
        match declaration:
            case Choice():
                values[key] = _values_of(cls, key)[held]
            case Curve():
                values[key] = declaration.read(held)
            case _:
                values[key] = authored(held)
        if declaration.optional and not values[key] and values[key] != ():
            values[key] = None
    return values


def held_values(group: Any, item: Any) -> dict[str, Any]:
    """What properties of a group hold of the fields of ``item``, by their names; None of unknown
    choices."""
    declarations = declared(item.__class__)
    held = group.held.get(type(item), _NOTHING)
    return {name: _held_as(declarations[key], getattr(item, key)) for key, name in held.items()}


def write_values(group: Any, item: Any) -> list[str]:
    """Set the properties of a group to what they hold of the fields of ``item``. Returns sentences
    about losses."""
    losses = []
    values = held_values(group, item)
    for key, name in group.held.get(type(item), _NOTHING).items():
        if values[name] is None:
            losses.append(f"{key.replace('_', ' ')} {getattr(item, key)!r}")
        else:
            setattr(group, name, values[name])
    return losses
