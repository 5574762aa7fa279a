"""Blender's events: a frame change traces the frame, an edit traces it again, a file load forgets everything."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy
from bpy.app.handlers import persistent
from bpy.types import Depsgraph, Scene

from ..bake import playback
from ..changes.suspension import is_stepped, is_suspended
from ..live_output import handlers as live_output
from ..session import session
from ..view import explanation, meters, overlay


@persistent
def frame_change_pre(*_: Any) -> None:
    """Blender begins to evaluate a frame."""
    session.frame_begins()


@persistent
def frame_change_post(scene: Scene, depsgraph: Depsgraph) -> None:
    """Trace the frame that Blender has just evaluated, or read it from the baked track."""
    if is_suspended() or depsgraph.mode == "RENDER":
        return
    session.frame_evaluated()
    if is_stepped(scene):
        session.begin(scene, depsgraph)
        return
    try:
        if scene.haptics.tracing and not playback.play(scene):
            session.begin(scene, depsgraph, live=True)
    finally:
        live_output.frame_changed(scene)


@persistent
def depsgraph_update_post(scene: Scene, depsgraph: Depsgraph) -> None:
    """Trace the frame again after an edit; while the timeline plays, `frame_change_post` does it."""
    if is_suspended() or is_stepped(scene) or depsgraph.mode == "RENDER" or _is_playing():
        return
    session.mark_edited()
    if not scene.haptics.tracing or playback.keep_up(scene):
        return
    if _edited(depsgraph):
        session.of(scene).reader.forget()
    if session.trace(scene, depsgraph, live=True) is not None:
        overlay.redraw()


@persistent
def forget_everything(*_: Any) -> None:
    """Before and after another file is loaded."""
    session.clear()
    overlay.forget()
    meters.forget()
    explanation.forget()
    playback.forget()


@persistent
def reread(*_: Any) -> None:
    """After undo and redo any property may be another."""
    session.mark_changed()


def _is_playing() -> bool:
    screen = bpy.context.screen
    return screen is not None and screen.is_animation_playing


def _edited(depsgraph: Depsgraph) -> bool:
    """True where more than the transforms of objects changed."""
    return any(not isinstance(u.id, bpy.types.Object) or not u.is_updated_transform or u.is_updated_geometry for u in depsgraph.updates)


_HANDLERS: dict[str, Callable[..., None]] = {
    "frame_change_pre": frame_change_pre,
    "frame_change_post": frame_change_post,
    "depsgraph_update_post": depsgraph_update_post,
    "load_pre": forget_everything,
    "load_post": forget_everything,
    "undo_post": reread,
    "redo_post": reread,
}


def register() -> None:
    for event, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, event).append(handler)


def unregister() -> None:
    for event, handler in _HANDLERS.items():
        handlers = getattr(bpy.app.handlers, event)
        if handler in handlers:
            handlers.remove(handler)
    session.clear()
