"""Problems of a scene."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Problem:
    """A problem that a designer should mend: the object's name ("" for the scene) and a message in the words of the panel; ``rule``: where
    it is in a table of rules, the table's name and the number of the row."""

    object: str
    message: str
    rule: tuple[str, int] | None = None
