"""Revision numbers, which grow with every change, so that readers can tell whether their copy is
current."""

from __future__ import annotations

_changes = {"authored": 0, "edits": 0, "actuators": 0}
"""Numbers of changes by kind since the add-on was loaded."""


def mark_changed() -> None:
    """Count a change of something authored, in any scene."""
    _changes["authored"] += 1


def mark_edited() -> None:
    """Count an edit in Blender, which may or may not affect something authored."""
    _changes["edits"] += 1


def mark_actuators() -> None:
    """Count a choice of an actuator for a listener."""
    _changes["actuators"] += 1


def authored() -> int:
    """Revision of everything that an author can change."""
    return _changes["authored"]


def edits() -> int:
    """Revision of everything in Blender, authored values included."""
    return _changes["authored"] + _changes["edits"]


def actuators() -> int:
    """Revision of the choices of actuators."""
    return _changes["actuators"]
