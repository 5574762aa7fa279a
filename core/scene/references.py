"""Checks of names and references, with the place of an error in the scene."""

from __future__ import annotations

from collections.abc import Collection, Container, Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any, TypeVar

Item = TypeVar("Item")

_ALIKE = 0.76
"""Least likeness of a name that is taken for a slip of another one, 1 for the same letters."""

_OTHER_WORDS = {"cube": "box", "ball": "sphere", "rod": "cylinder", "hull": "convex_hull"}
"""Other words for names."""

Place = tuple[str | int, ...]
"""Keys and indices that lead to a value of a scene."""


class PlacedError(ValueError):
    """An error in a scene, with its ``place`` and its ``reason``."""

    def __init__(self, place: Place, reason: str) -> None:
        super().__init__(f"{'/'.join(map(str, place))}: {reason}")
        self.place = place
        self.reason = reason


def meant(name: Any, known: Iterable[Any], words: str = ", did you mean {!r}?") -> str:
    """A suggestion, the ``words`` with the one of the ``known`` names that is spelt most like
    ``name`` or another word for it; "" if none is similar."""
    if not isinstance(name, str):
        return ""
    by_letters = {one.casefold(): one for one in known if isinstance(one, str)}
    word = _OTHER_WORDS.get(name.casefold(), name.casefold())
    near = get_close_matches(word, by_letters, 1, _ALIKE)
    return words.format(by_letters[near[0]]) if near else ""


def named(name: str, known: Mapping[str, Item], kind: str) -> Item:
    """The item called ``name``. Raises ValueError, which lists the ``known`` names of that kind, if
    there is none."""
    if name not in known:
        raise ValueError(
            f"{kind} {name!r} is unknown{meant(name, known)}: use one of {', '.join(known)}"
        )
    return known[name]


def require_known(name: str, known: Collection[str], kind: str, place: Place) -> None:
    """Raise PlacedError unless ``name`` is one of the ``known`` names of that kind."""
    if name not in known:
        raise PlacedError(place, f"there is no {kind} {name!r}{meant(name, known)}")


def require_unique(names: Sequence[str], kind: str, key: str) -> None:
    """Raise PlacedError if an item of the list ``key`` has the name of an earlier one."""
    if len(set(names)) == len(names):
        return
    index = next(i for i, name in enumerate(names) if name in names[:i])
    require_new(names[index], names[:index], kind, (key, index, "name"))


def require_new(name: str, known: Container[str], kind: str, place: Place) -> None:
    """Raise PlacedError if ``name`` is already one of the ``known`` names of that kind."""
    if name in known:
        raise PlacedError(
            place, f"there is {'an' if kind[0] in 'aeiou' else 'a'} {kind} {name!r} already"
        )
