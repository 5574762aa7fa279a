"""Classes of values that don't change."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, dataclass_transform


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def frozen(cls: Any = None, **options: bool) -> Any:
    """Class decorator: a dataclass whose values are immutable, compared by content, and have slots
    in place of a dictionary. ``options``: further or other ones of `dataclass`."""
    return dataclass(cls, **{"frozen": True, "slots": True} | options)
