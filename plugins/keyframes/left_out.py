"""Reading what is left of a document without its damaged parts."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from ...core.formats.io.error import FormatError, json_pointer

MOST = 20
"""Parts that are left out; a file with more is refused."""

Read = TypeVar("Read")
Part = tuple[str, ...]
"""The place of a part that a file makes sense without: keys, ``*`` for every index."""


def without_damaged(
    document: Any, parts: Sequence[Part], losses: dict[str, None], read: Callable[[], Read]
) -> Read:
    """What ``read`` makes of ``document``, from which the ``parts`` that it refuses, inner ones
    first, are removed one after the other; each is named in ``losses``. Raises FormatError for
    other faults, and where nothing would remain of a list."""
    removed: dict[tuple[str, ...], list[int]] = defaultdict(list)
    for left in range(MOST, -1, -1):
        try:
            return read()
        except FormatError as error:
            keys = error.pointer.replace("~1", "/").replace("~0", "~").split("/")[1:]
            place = _removed(document, keys, parts) if left else None
            if place is None:
                raise
            *holder, last = place
            if last.isdecimal():
                number = int(last)
                gone = removed[tuple(holder)]
                for before in sorted(gone):
                    number += before <= number
                gone.append(number)
                last = str(number)
            losses[f"{json_pointer([*holder, last])} is left out: {error.reason}"] = None
    raise AssertionError("the last attempt returns or raises")


def _removed(document: Any, keys: Sequence[str], parts: Sequence[Part]) -> list[str] | None:
    """Remove from a document what is at the place ``keys``, or the innermost of the removable
    ``parts`` that contain it. Returns the place of what was removed, None if nothing can be."""
    for part in sorted(parts, key=len, reverse=True):
        place = list(keys[: len(part)])
        if len(place) < len(part) or any(
            key not in ("*", found) for key, found in zip(part, place, strict=True)
        ):
            continue
        holder = document
        for key in place[:-1]:
            holder = holder[int(key) if isinstance(holder, list) else key]
        if isinstance(holder, dict) and place[-1] in holder:
            del holder[place[-1]]
            return place
        if isinstance(holder, list) and len(holder) > 1:
            del holder[int(place[-1])]
            return place
    return None
