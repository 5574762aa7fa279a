"""Something that is wrong with a scene."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Problem:
    """Something a designer should mend: the object's name ("" for the scene) and what to do, in the words of the panel."""

    object: str
    message: str
