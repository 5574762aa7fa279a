"""Suspension of handlers while the add-on draws or renders, and while it steps through the frames
of a scene itself."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager

from bpy.types import Scene

_suspended: list[int] = []
"""An entry per nested suspension."""
_stepped: list[int] = []
"""Session ids of the scenes that the add-on steps through."""


def is_suspended() -> bool:
    """Whether handlers are to do nothing, inside `suspended`."""
    return bool(_suspended)


def suspended() -> AbstractContextManager[None]:
    """A context in which handlers do nothing; may be nested."""
    return _listed(_suspended, len(_suspended))


def is_stepped(scene: Scene) -> bool:
    """Whether the add-on steps through the frames of this scene, as a bake does: inside
    `stepped`."""
    return scene.session_uid in _stepped


def steps_any() -> bool:
    """True while the add-on steps through the frames of any scene."""
    return bool(_stepped)


def stepped(scene: Scene) -> AbstractContextManager[None]:
    """A context in which every frame of the scene is traced, independent of the preview settings,
    and edits are not traced."""
    return _listed(_stepped, scene.session_uid)


@contextmanager
def _listed(entries: list[int], entry: int) -> Iterator[None]:
    """A context in which ``entries`` also contain ``entry``."""
    entries.append(entry)
    try:
        yield
    finally:
        entries.remove(entry)
