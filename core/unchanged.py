"""Values that are made again only when what they are made of has changed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, ParamSpec, TypeVar

Parts = ParamSpec("Parts")
Value = TypeVar("Value")


class Unchanged(Generic[Parts, Value]):
    """What ``make`` returns for its arguments, made again where these differ from the last ones."""

    def __init__(self, make: Callable[Parts, Value]) -> None:
        self._make = make
        self._last: tuple[tuple[object, ...], Value] | None = None

    def __call__(self, *parts: Parts.args, **_: Parts.kwargs) -> Value:
        last = self._last
        value = last[1] if last is not None and last[0] == parts else self._make(*parts, **_)
        self._last = parts, value  # parts that are the same objects next time are compared at once
        return value
