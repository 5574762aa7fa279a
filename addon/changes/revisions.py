"""Revision numbers: they grow with every change, so that whoever read something can tell whether to read it again."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class _Revisions:
    """How many changes there have been of each kind since the add-on was loaded."""

    authored: int = 0
    edits: int = 0
    actuators: int = 0


_revisions = _Revisions()


def mark_changed() -> None:
    """Something that an author can change has changed, in some scene."""
    _revisions.authored += 1


def mark_edited() -> None:
    """Something in Blender was edited; what an author set may or may not depend on it."""
    _revisions.edits += 1


def mark_actuators() -> None:
    """Another actuator was chosen for some listener."""
    _revisions.actuators += 1


def authored() -> int:
    """Revision of everything that an author can change."""
    return _revisions.authored


def edits() -> int:
    """Revision of everything in Blender, authored values included."""
    return _revisions.authored + _revisions.edits


def actuators() -> int:
    """Revision of the choices of actuators."""
    return _revisions.actuators
