"""The options of every format as properties of an operator."""

from __future__ import annotations

import math
from typing import Any

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty
from bpy.types import UILayout

from ...core.formats.io.catalogue import named
from ...core.formats.io.options import Option, Value
from ..blender.single_precision import shortest

LARGEST = 2**31 - 1


def option_properties(names: tuple[str, ...]) -> dict[str, Any]:
    """Annotations of an operator: ``<format>_<option>`` for every option of the formats ``names``."""
    return {_key(name, option): _property(option) for name in names for option in named(name).options}


def chosen(operator: Any, name: str) -> dict[str, Value]:
    """The chosen options of a format."""
    return {option.name: _value(option, getattr(operator, _key(name, option))) for option in named(name).options}


def draw_options(layout: UILayout, operator: Any, name: str) -> None:
    """Draw the options of a format in a column."""
    for option in named(name).options:
        layout.prop(operator, _key(name, option))


def _key(name: str, option: Option) -> str:
    return f"{name}_{option.name}"


def _value(option: Option, value: Any) -> Value:
    return min(max(shortest(value), option.minimum), option.maximum) if isinstance(option.default, float) else value


def _property(option: Option) -> Any:
    text: dict[str, Any] = {"name": option.label, "description": option.description}
    if isinstance(option.default, bool):
        return BoolProperty(default=option.default, **text)
    if isinstance(option.default, str):
        return EnumProperty(items=[(choice, choice, "") for choice in option.choices], default=option.default, **text)
    bounds: dict[str, Any] = {
        key: value for key, value in (("min", option.minimum), ("max", option.maximum)) if math.isfinite(value) and abs(value) <= LARGEST
    }
    if isinstance(option.default, int):
        bounds = {key: int(value) for key, value in bounds.items()}
        return IntProperty(default=option.default, **bounds, **text)
    return FloatProperty(default=option.default, precision=3, **bounds, **text)
