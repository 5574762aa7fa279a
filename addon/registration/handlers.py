"""Blender's events: a frame change traces the frame, an edit traces it again, a file load forgets everything."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy
from bpy.app.handlers import persistent
from bpy.types import Depsgraph, Scene

from ..bake import playback
from ..blender import job
from ..blender.playing import is_playing
from ..changes.redraw import redraw_viewports
from ..changes.revisions import mark_changed, mark_edited
from ..changes.suspension import is_stepped, is_suspended
from ..live_output import handlers as live_output
from ..operators import bake
from ..session import session
from ..view import gain_plot, meter_pictures, meters, overlay


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
            live_output.frame_comes(scene)
            session.begin(scene, depsgraph, live=True)
    finally:
        live_output.frame_changed(scene, playback.plays(scene))


@persistent
def depsgraph_update_post(scene: Scene, depsgraph: Depsgraph) -> None:
    """Trace the frame again after an edit; while the timeline plays, `frame_change_post` does it."""
    if is_suspended() or is_stepped(scene) or depsgraph.mode == "RENDER" or is_playing():
        return
    mark_edited()
    if not scene.haptics.tracing or playback.keep_up(scene):
        return
    if _edited(depsgraph):
        session.of(scene).reader.forget()
    if session.trace(scene, depsgraph, live=True) is not None:
        redraw_viewports()


@persistent
def forget_everything(*_: Any) -> None:
    """Before and after another file is loaded."""
    session.clear()
    overlay.forget()
    meters.forget()
    playback.forget()


@persistent
def reread(*_: Any) -> None:
    """After undo and redo any property may be another."""
    mark_changed()


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
    """Start listening to Blender's events."""
    for event, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, event).append(handler)
    playback.register()
    live_output.register()


def unregister() -> None:
    """Stop listening, end what is going on, and forget everything."""
    job.stop()
    bake.stop()
    live_output.unregister()
    playback.unregister()
    for event, handler in _HANDLERS.items():
        handlers = getattr(bpy.app.handlers, event)
        if handler in handlers:
            handlers.remove(handler)
    forget_everything()
    gain_plot.forget()
    meter_pictures.forget()
