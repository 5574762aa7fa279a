"""Problems of a scene."""

from __future__ import annotations

from collections.abc import Sequence

from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Object

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


def lost(obj: Object) -> Problem:
    """The problem of an object whose world matrix is not finite."""
    words = iface_(
        "its location, rotation or scale is not a number: look for a constraint, simulation or "
        "script that fails"
    )
    return Problem(obj.name_full, words)


def only_instances(obj: Object) -> Problem:
    """The problem of a source or listener whose only surface is that of its instances."""
    words = iface_(
        "it has no surface but its instances, which are no sources or listeners: use Realize "
        "Instances"
    )
    return Problem(obj.name_full, words)


def without_carrier(obj: Object, role: str) -> Problem:
    """The problem of a source or listener without a haptic object that carries it; the same one for
    all on one armature, so that it is shown once."""
    above: Object | None = obj
    while above is not None and above.type != "ARMATURE":
        above = above.parent
    if above is not None:
        words = iface_(
            "its listeners and sources are on no haptic object: choose its Body in the panel "
            "Selected Object, and make that haptic"
        )
        return Problem(above.name_full, words)
    if role == "source":
        words = iface_("This source is on no haptic object: make it haptic, or parent it to one")
    else:
        words = iface_("This listener is on no haptic object: make it haptic, or parent it to one")
    return Problem(obj.name_full, words)
