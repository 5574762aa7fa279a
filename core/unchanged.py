"""Values that are made again only when what they are made of has changed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, ParamSpec, TypeVar

Parts = ParamSpec("Parts")
Value = TypeVar("Value")


class Unchanged(Generic[Parts, Value]):
    """What ``make`` returns for its arguments: the same object as long as these are the same
    objects. All that is made of it in turn then stays as it is, too."""

    def __init__(self, make: Callable[Parts, Value]) -> None:
        self._make = make
        self._last: tuple[tuple[object, ...], Value] | None = None

    def __call__(self, *parts: Parts.args, **_: Parts.kwargs) -> Value:
        last = self._last
        if last is None or any(a is not b for a, b in zip(parts, last[0], strict=True)):
            last = self._last = parts, self._make(*parts, **_)
        return last[1]
