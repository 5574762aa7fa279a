"""Problems of a scene."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Problem:
    """A problem for the designer to fix: the object's name ("" for the scene) and a message for the user; ``rule``: the name of a table and
    the number of the row for a problem in a table of rules."""

    object: str
    message: str
    rule: tuple[str, int] | None = None
