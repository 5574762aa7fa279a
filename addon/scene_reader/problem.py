"""Problems of a scene."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Problem:
    """A problem that a designer should mend: the object's name ("" for the scene) and a message in the words of the panel."""

    object: str
    message: str
