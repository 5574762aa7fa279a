"""Checks of names and of references between the parts of a scene."""

from __future__ import annotations

from collections.abc import Container, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .values import Contact, HapticObject, Listener, Source

Place = tuple[str | int, ...]
"""Keys and indices that lead to a value of a scene."""


class PlacedError(ValueError):
    """An error in a scene; ``place`` is where it stands, ``reason`` what is wrong."""

    def __init__(self, place: Place, reason: str) -> None:
        super().__init__(f"{'/'.join(map(str, place))}: {reason}")
        self.place = place
        self.reason = reason


def require_known(name: str, known: Container[str], kind: str, place: Place) -> None:
    """Raise PlacedError unless ``name`` is one of the ``known`` names of that kind."""
    if name not in known:
        raise PlacedError(place, f"there is no {kind} {name!r}")


def require_unique(names: Sequence[str], kind: str, key: str) -> None:
    """Raise PlacedError where an item of the list ``key`` has the name of an earlier one."""
    if len(set(names)) == len(names):
        return
    index = next(i for i, name in enumerate(names) if name in names[:i])
    raise PlacedError((key, index, "name"), f"there is {'an' if kind[0] in 'aeiou' else 'a'} {kind} {names[index]!r} already")


def check_references(
    objects: Sequence[HapticObject], contacts: Sequence[Contact], sources: Sequence[Source], listeners: Sequence[Listener]
) -> None:
    """Raise PlacedError unless names are unique within their list and every object that is named exists."""
    require_unique([item.name for item in objects], "object", "objects")
    require_unique([item.name for item in sources], "source", "sources")
    require_unique([item.name for item in listeners], "listener", "listeners")
    known = {item.name for item in objects}
    for i, contact in enumerate(contacts):
        for k, name in enumerate(contact.objects):
            require_known(name, known, "object", ("contacts", i, "objects", k))
    for i, source in enumerate(sources):
        require_known(source.object, known, "object", ("sources", i, "object"))
        if source.second_object is not None:
            require_known(source.second_object, known, "object", ("sources", i, "second_object"))
    for i, listener in enumerate(listeners):
        require_known(listener.object, known, "object", ("listeners", i, "object"))
