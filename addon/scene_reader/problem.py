"""Problems of a scene."""

from __future__ import annotations

from collections.abc import Sequence

from ...core.frozen import frozen
from ..blender.words import report_text


@frozen
class Problem:
    """A problem for the designer to fix: the object's name ("" for the scene) and a message for the
    user; ``rule``: the name of a table and the number of the row for a problem in a table of
    rules."""

    object: str
    message: str
    rule: tuple[str, int] | None = None


def why_untraced(problems: Sequence[Problem]) -> str:
    """Why a scene with these problems has no result, for the user."""
    return (
        problems[0].message
        if problems
        else report_text("Nothing is tagged: select objects and press Make Haptic")
    )
