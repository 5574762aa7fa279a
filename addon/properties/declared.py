"""Blender's properties of declared fields (`core.scene.declaration`): their definitions, and what they hold of a value."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import get_annotations
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty
from bpy.types import PropertyGroup

from ...core.scene.declaration import Choice, Declaration, Number, Numbers, Switch, Text, declared, default_of, shown
from ..blender.single_precision import authored

_Group = TypeVar("_Group", bound=type[PropertyGroup])
_UNITS = {"m": "LENGTH", "kg": "MASS", "m/s": "VELOCITY"}
"""Units that Blender shows itself; labels name others."""
_LEAST = float(np.finfo(np.float32).tiny)
"""The least number above 0 that a property holds."""
_NOTHING: Mapping[str, Any] = MappingProxyType({})
IDENTIFIERS = {"": "NONE"}
"""Blender's identifiers of values that have others in the core."""


def holding(cls: type, more: Mapping[str, Mapping[str, Any]] = _NOTHING, **names: str) -> Callable[[_Group], _Group]:
    """Decorator: the group gets a property for each field of ``cls`` that has a label, after its own properties.

    Args:
        cls: A class with declared fields.
        more: Further arguments of Blender's properties, by field.
        names: Names of properties, by field, where they differ.
    """

    def decorate(group: _Group) -> _Group:
        held = {key: names.get(key, key) for key in shown(cls)}
        made = {held[key]: _property(cls, key, item, more.get(key, _NOTHING)) for key, item in shown(cls).items()}
        group.__annotations__ = {**get_annotations(group), **made}
        group.held = {**getattr(group, "held", {}), cls: held}  # type: ignore[attr-defined]
        return group

    return decorate


def _property(cls: type, key: str, declaration: Declaration, more: Mapping[str, Any]) -> Any:
    """The property of a field."""
    unit = getattr(declaration, "unit", "")
    default = default_of(cls, key) if declaration.shown is None else declaration.shown
    common: dict[str, Any] = {
        "name": declaration.label if unit in ("", *_UNITS) else f"{declaration.label} ({unit})",
        "description": declaration.about,
        "default": default,
        **({} if declaration.animated else {"options": set()}),
        **more,
    }
    match declaration:
        case Switch():
            return BoolProperty(**common)
        case Choice():
            items = [(identifier(value), *item) for value, item in declaration.items.items()]
            return EnumProperty(**{**common, "items": items, "default": identifier(default)})
        case Numbers():
            return FloatVectorProperty(**{"size": declaration.count, **_limits(declaration), **common})
        case Number(whole=True):
            return IntProperty(**{**_limits(declaration), **common})
        case Number():
            subtype = "FACTOR" if declaration.high == 1 else "NONE"
            return FloatProperty(**{"subtype": subtype, "unit": _UNITS.get(unit, "NONE"), **_limits(declaration), **common})
    return StringProperty(**common)


def _limits(declaration: Number) -> dict[str, Any]:
    limits: dict[str, Any] = {"min": _LEAST if declaration.above and not declaration.low else declaration.low, "max": declaration.high}
    if declaration.soft is not None:
        limits |= {"soft_min": declaration.soft[0], "soft_max": declaration.soft[1]}
    return limits if declaration.digits is None else {**limits, "precision": declaration.digits}


def identifier(value: str) -> str:
    """The identifier of a value in Blender."""
    return IDENTIFIERS.get(value, str(value))


def held_as(cls: type, key: str, value: Any) -> Any:
    """What a property holds of a value of a field, such as the nearest number; None for an unknown choice."""
    declaration = declared(cls)[key]
    match declaration:
        case Choice():
            return identifier(value) if value in declaration.items else None
        case Numbers():
            return tuple(_nearest(declaration, number) for number in value)
        case Number(whole=True):
            return int(min(max(value, declaration.low), declaration.high))
        case Number():
            return _nearest(declaration, value)
        case Text():
            return value or declaration.shown or ""
    return value


def value_of(cls: type, key: str, held: Any) -> Any:
    """The value of a field of which a property holds ``held``."""
    declaration = declared(cls)[key]
    if isinstance(declaration, Choice):
        return next(value for value in declaration.items if identifier(value) == held)
    return authored(held)


def _nearest(declaration: Number, value: float) -> float:
    limits = _limits(declaration)
    return float(min(max(np.float32(value), np.float32(limits["min"])), np.float32(limits["max"])))
