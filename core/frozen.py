"""Classes of values that don't change."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeVar, dataclass_transform

Value = TypeVar("Value")


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def frozen(cls: type[Value]) -> type[Value]:
    """Class decorator: a dataclass whose values are immutable, compared by content, and have slots
    in place of a dictionary."""
    return dataclass(frozen=True, slots=True)(cls)
