"""Classes of values that don't change."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar, dataclass_transform, overload

T = TypeVar("T")


@overload
@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def frozen(cls: type[T], /) -> type[T]: ...


@overload
@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def frozen(
    *, eq: bool = True, kw_only: bool = False, repr: bool = True, slots: bool = True
) -> Callable[[type[T]], type[T]]: ...


def frozen(cls: Any = None, /, **options: bool) -> Any:
    """Class decorator: a dataclass whose values are immutable, compared by content, and have slots
    in place of a dictionary. ``options``: further or other ones of `dataclass`."""
    return dataclass(cls, **{"frozen": True, "slots": True} | options)
