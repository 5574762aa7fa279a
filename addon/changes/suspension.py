"""Who is in charge of tracing: nobody while the add-on draws or renders, the add-on itself while it steps through the frames of a scene."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from bpy.types import Scene

_depth = 0
_stepped: list[int] = []  # session ids of scenes


def is_suspended() -> bool:
    """True inside `suspended`."""
    return _depth > 0


@contextmanager
def suspended() -> Iterator[None]:
    """Handlers do nothing inside; may be nested."""
    global _depth
    _depth += 1
    try:
        yield
    finally:
        _depth -= 1


def is_stepped(scene: Scene) -> bool:
    """True inside `stepped`."""
    return scene.session_uid in _stepped


@contextmanager
def stepped(scene: Scene) -> Iterator[None]:
    """Every frame that the scene comes to is traced, whatever is chosen for the preview, and edits are not."""
    scene_id = scene.session_uid
    _stepped.append(scene_id)
    try:
        yield
    finally:
        _stepped.remove(scene_id)
