"""Suspension of handlers while the add-on draws or renders, and while it steps through the frames of a scene itself."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from bpy.types import Scene


@dataclass(slots=True)
class _State:
    """``depth``: number of nested suspensions. ``stepped``: session ids of the scenes that the add-on steps through."""

    depth: int = 0
    stepped: list[int] = field(default_factory=list)


_state = _State()


def is_suspended() -> bool:
    """True inside `suspended`."""
    return _state.depth > 0


@contextmanager
def suspended() -> Iterator[None]:
    """A context in which handlers do nothing; may be nested."""
    _state.depth += 1
    try:
        yield
    finally:
        _state.depth -= 1


def is_stepped(scene: Scene) -> bool:
    """True inside `stepped`."""
    return scene.session_uid in _state.stepped


def steps_any() -> bool:
    """True while the add-on steps through the frames of any scene."""
    return bool(_state.stepped)


@contextmanager
def stepped(scene: Scene) -> Iterator[None]:
    """A context in which every frame of the scene is traced, independent of the preview settings, and edits are not traced."""
    scene_id = scene.session_uid
    _state.stepped.append(scene_id)
    try:
        yield
    finally:
        _state.stepped.remove(scene_id)
