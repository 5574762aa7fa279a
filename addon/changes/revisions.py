"""Revision numbers, which grow with every change, so that readers can tell whether their copy is
current."""

from __future__ import annotations

from collections.abc import Collection

_changes = {"authored": 0, "everywhere": 0, "edits": 0, "actuators": 0}
"""Numbers of changes by kind since the add-on was loaded; ``everywhere``: the revision of the last
one that wasn't of certain objects alone."""

_objects: dict[int, int] = {}
"""The last revision since then in which an object changed, by session id."""

SCENE = 0
"""In place of a session id: the settings and rules of scenes."""


def mark_changed(objects: Collection[int] | None = None) -> None:
    """Count a change of something authored, in any scene. ``objects``: session ids of those that
    it is of, or `SCENE`; None if others may depend on it."""
    _changes["authored"] += 1
    if objects is None:
        _changes["everywhere"] = _changes["authored"]
        _objects.clear()
    else:
        for number in objects:
            _objects[number] = _changes["authored"]


def changed_since(revision: int) -> frozenset[int] | None:
    """Session ids of the objects whose authored values have changed since a revision, and `SCENE`
    if settings or rules have; None if those of any object may have."""
    if revision < _changes["everywhere"]:
        return None
    return frozenset(number for number, last in _objects.items() if last > revision)


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
