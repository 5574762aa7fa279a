"""Values of Blender's datablocks as plain data, and checksums of them."""

from __future__ import annotations

import zlib
from collections.abc import Collection, Iterable
from typing import Any

_NOT_EFFECTIVE = ("open_", "show_", "select", "is_active", "active", "use_pin", "strip_time")
"""Beginnings of the names of properties of modifiers, constraints and strips that have no
effect."""
PLAIN_TYPES = {"BOOLEAN", "INT", "FLOAT", "STRING", "ENUM"}
"""Types of properties that hold plain values."""
_LONG = 60  # characters of a text that a digest holds
TRANSFORM = (
    *("location", "rotation_euler", "rotation_quaternion", "rotation_axis_angle"),
    *("scale", "rotation_mode"),
    *("delta_location", "delta_rotation_euler", "delta_rotation_quaternion", "delta_scale"),
)
"""Properties of an object that place it."""


def writable(item: Any, types: Collection[str]) -> list[str]:
    """The names of an item's properties of these types that can be written and have an effect."""
    found = (p for p in item.bl_rna.properties if p.type in types and not p.is_readonly)
    return [p.identifier for p in found if not p.identifier.startswith(_NOT_EFFECTIVE)]


def values_of(owner: Any, keys: Iterable[str]) -> list[Any]:
    """The names and plain values of properties."""
    return [(key, plain(getattr(owner, key))) for key in keys]


def plain(value: Any) -> Any:
    """A value as JSON has it: numbers with six digits, sets sorted, long texts shortened."""
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, str):
        return value if len(value) <= _LONG else f"{value[:_LONG]}... {checksum(value)}"
    if value is None or isinstance(value, (bool, int, tuple)):
        return value
    return [plain(part) for part in (sorted(value) if isinstance(value, set) else value)]


def checksum(value: Any) -> str:
    """Eight hexadecimal digits that are equal for equal plain values."""
    return f"{zlib.crc32(repr(value).encode()):08x}"
