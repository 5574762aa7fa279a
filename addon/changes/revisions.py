"""Revision numbers, which grow with every change, so that readers can tell whether their copy is current."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class _Revisions:
    """Numbers of changes by kind since the add-on was loaded."""

    authored: int = 0
    edits: int = 0
    actuators: int = 0


_revisions = _Revisions()


def mark_changed() -> None:
    """Count a change of something authored, in any scene."""
    _revisions.authored += 1


def mark_edited() -> None:
    """Count an edit in Blender, which may or may not affect something authored."""
    _revisions.edits += 1


def mark_actuators() -> None:
    """Count a choice of an actuator for a listener."""
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
