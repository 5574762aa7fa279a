"""Blender's events: a frame change traces the frame, an edit traces it again, a file load drops
everything.

In scenes without haptic objects they return without loading the core.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Container
from functools import partial
from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.handlers import persistent
from bpy.types import ID, Depsgraph, DepsgraphUpdate, Mesh, Object, Scene

from ..bake import playback
from ..blender import job
from ..blender.handlers import Handlers, are_frames_shared
from ..blender.time import Moment, is_playing
from ..changes import events
from ..changes.redraw import redraw_viewports
from ..changes.revisions import mark_changed, mark_edited
from ..changes.suspension import is_stepped, is_suspended, steps_any
from ..gateway import is_loaded
from ..io import stored_paths
from ..live_output import handlers as live_output
from ..scene_reader import roles
from ..scene_reader.present import traced_layer
from ..session import session, sessions, worker
from . import properties

if TYPE_CHECKING:
    from ..scene_reader.evaluation import Evaluation

_PATIENCE = 1.0
"""Longest wait of a frame for the trace of the one before [s]."""


@persistent
def frame_change_pre(*_: Any) -> None:
    """Blender begins to evaluate a frame; the last one is still there to be read."""
    _read_postponed()
    sessions.evaluation_begins()


@persistent
def frame_change_post(scene: Scene, depsgraph: Depsgraph) -> None:
    """Trace the frame that Blender has just evaluated, or read it from the baked track.

    Where other add-ons have handlers of frames, too, Blender evaluates after them what they have
    changed, without an event: the frame is read after that.
    """
    is_shared = are_frames_shared()
    evaluation = _noted(depsgraph, names_all=not is_shared)
    if is_suspended() or is_stepped(scene) or not _is_traced(depsgraph) or not _is_concerned(scene):
        return
    sessions.evaluation_ends()
    is_traced = scene.haptics.tracing and not playback.play(scene) and _is_ready(scene)
    if is_traced:
        live_output.frame_comes(scene)
    follow = partial(_follow_frame, Moment.of(scene), playback.impacts_of(scene), evaluation)
    try:
        if is_traced and is_shared:
            session.postpone(scene, follow)
            _call_soon(_read_postponed)
        else:
            follow(scene, depsgraph if is_traced else None)
    finally:
        _make_way(_PATIENCE)


def _follow_frame(
    moment: Moment,
    baked_impacts: str,
    evaluation: Evaluation | None,
    scene: Scene,
    depsgraph: Depsgraph | None,
) -> None:
    """Begin to trace a frame, unless ``depsgraph`` is None, and play it on the devices."""
    try:
        if depsgraph is not None:
            session.begin(
                scene,
                depsgraph,
                live=True,
                plays=live_output.is_wanted(scene),
                baked_impacts=baked_impacts,
                evaluation=evaluation,
                moment=moment,
            )
    finally:
        if live_output.is_wanted(scene):
            live_output.frame_changed(scene, playback.plays(scene))


def _read_postponed() -> None:
    """Read the frames that Blender has finished since their handlers ran."""
    if is_loaded(session):
        session.read_postponed()


@persistent
def depsgraph_update_post(scene: Scene, depsgraph: Depsgraph) -> None:
    """Trace the frame again after an edit; while the timeline plays, `frame_change_post` does
    it."""
    _noted(depsgraph)
    if is_suspended() or is_stepped(scene) or not _is_traced(depsgraph) or is_playing():
        return
    mark_edited()
    _mark_changes(depsgraph)
    if not scene.haptics.tracing or not _is_concerned(scene):
        return
    if session.follow_edit(scene, depsgraph):
        redraw_viewports()
    _make_way(worker.MOMENT)


@persistent
def file_changed(*_: Any) -> None:
    """Before and after another file is loaded."""
    mark_changed()
    events.file_changed()


@persistent
def file_loaded(*_: Any) -> None:
    """After another file is loaded: trace its current frame as soon as it is drawn."""
    file_changed()
    _trace_soon()


def _trace_soon() -> None:
    _call_soon(trace_opened)


def _call_soon(timer: Callable[[], None]) -> None:
    """Call a function from Blender's event loop."""
    if not bpy.app.background and not bpy.app.timers.is_registered(timer):
        bpy.app.timers.register(timer, first_interval=0.0)


def trace_opened() -> None:
    """Begin to trace the scenes of the windows that have no result, or only one from a baked track,
    without waiting."""
    for window in bpy.context.window_manager.windows:
        scene = window.scene
        shown = sessions.shown(window.scene)
        is_due = (shown is None or playback.is_from_track(shown.result)) and not sessions.is_behind(
            scene
        )
        if scene.haptics.tracing and is_due and _is_concerned(scene) and not playback.plays(scene):
            with bpy.context.temp_override(window=window):
                session.begin(
                    scene,
                    bpy.context.evaluated_depsgraph_get(),
                    live=True,
                    baked_impacts=playback.impacts_of(scene),
                )


@persistent
def imported(context: Any) -> None:
    """After objects of another file are appended or linked, assets among them."""
    objects = [item for item in context.import_items if isinstance(item.id, Object)]
    for item in objects:
        if item.source_library is not None and item.id.library is None:
            source = bpy.path.abspath(item.source_library.filepath)
            stored_paths.follow([item.id], source, bpy.data.filepath)


@persistent
def animation_playback_post(*_: Any) -> None:
    """Playback has stopped: trace the frame at which a baked track was played last."""
    _trace_soon()


@persistent
def saving(path: str = "", *_: Any) -> None:
    """Before the file is saved."""
    _move_paths(bpy.data.filepath, path)
    properties.create_overridden_groups()
    if is_loaded(session):
        for scene in bpy.data.scenes:
            if scene.is_editable:
                session.keep_impacts(scene)


@persistent
def saved(path: str = "", *_: Any) -> None:
    """After the file was saved, as a copy or in vain where it is not the open one."""
    _move_paths(path, bpy.data.filepath)


def _move_paths(before: str, after: str) -> None:
    if before and after:  # neither is the start-up file
        stored_paths.follow((*bpy.data.objects, *bpy.data.scenes), before, after)


@persistent
def cancel(*_: Any) -> None:
    """Before an undo, or before Blender exits: cancel the running trace, which becomes obsolete."""
    if is_loaded(session):
        session.cancel()


@persistent
def render_pre(*_: Any) -> None:
    """Cancel the running trace during a render and repeat it afterwards. Called on the render
    thread."""
    if is_loaded(session) and not steps_any():
        session.cancel(resume=True)


@persistent
def reread(*_: Any) -> None:
    """Read everything again after undo and redo, which may change any property or mesh."""
    if is_loaded(session):
        session.recheck_shapes()
    mark_changed()
    _trace_soon()


def _is_traced(depsgraph: Depsgraph) -> bool:
    """Whether an evaluation is of the view layer that is traced: scripts and bakes that set a frame
    evaluate every layer of the scene, and renders their own."""
    return depsgraph.mode != "RENDER" and depsgraph.view_layer == traced_layer(depsgraph.scene)


def _is_concerned(scene: Scene) -> bool:
    """Whether a scene has haptic objects or a track, or any scene has had a session."""
    return is_loaded(session) or roles.is_any_tagged(scene) or scene.haptics.bake.track is not None


def _is_ready(scene: Scene) -> bool:
    """Whether a frame can be traced. During playback, wait up to `_PATIENCE` for the one before,
    then skip this one; otherwise cancel the one before."""
    if not session.is_busy(scene, _PATIENCE):
        return True
    if not is_playing():
        session.give_up()
    return not is_playing()


def _make_way(seconds: float) -> None:
    """End the worker's jobs before a script goes on, see `session.make_way`. Called by a handler,
    which was itself called by a script if it is not the outermost function."""
    if sys._getframe(1).f_back is not None and is_loaded(session):
        session.make_way(seconds)


def _mark_changes(depsgraph: Depsgraph) -> None:
    """Mark what an update has changed beyond transforms of objects."""
    edits = [
        update
        for update in depsgraph.updates
        if not isinstance(update.id, Object)
        or not update.is_updated_transform
        or update.is_updated_geometry
    ]
    if edits:
        world = depsgraph.scene.rigidbody_world
        expected: set[ID | None] = {None if world is None else world.collection}
        expected |= {edit.id.original for edit in edits if isinstance(edit.id, Mesh)}
        if any(_concerns_others(edit, expected) for edit in edits):
            mark_changed()
        elif bpy.app.version >= (5, 0, 0):
            mark_changed(())
        else:  # which names edits of a rigid body as it names moves
            mark_changed(
                [
                    changed.session_uid
                    for update in depsgraph.updates
                    if isinstance(changed := update.id and update.id.original, Object)
                    and changed.rigid_body
                ]
            )


def _concerns_others(update: DepsgraphUpdate, expected: Container[ID | None]) -> bool:
    """Whether an update may have changed more than what every reading compares, the settings of
    the scene, and what it names to `SceneReader.note`, an object or mesh. ``expected``: the
    collection of the rigid bodies, which Blender names whenever one of them moves, and meshes, with
    which it names all objects that share them."""
    changed = update.id and update.id.original
    if isinstance(changed, Object):
        shares = update.is_updated_geometry and changed.data in expected and not changed.modifiers
        return not (update.is_updated_transform or shares)
    if isinstance(changed, Mesh):
        return not update.is_updated_geometry
    return not isinstance(changed, Scene) and changed not in expected


def _noted(depsgraph: Depsgraph, names_all: bool = False) -> Evaluation | None:
    """Note what an evaluation may have changed, also if this frame is not traced: Blender does not
    name it again in a later one. See `session.note`."""
    if depsgraph.mode == "RENDER" or not is_loaded(session):
        return None
    return session.note(depsgraph, names_all)


_HANDLERS = Handlers(
    frame_change_pre=frame_change_pre,
    frame_change_post=frame_change_post,
    depsgraph_update_post=depsgraph_update_post,
    animation_playback_post=animation_playback_post,
    load_pre=file_changed,
    load_post=file_loaded,
    blend_import_post=imported,
    save_pre=saving,
    save_post=saved,
    save_post_fail=saved,
    undo_pre=cancel,
    redo_pre=cancel,
    undo_post=reread,
    redo_post=reread,
    render_pre=render_pre,
    exit_pre=cancel,
)


def register() -> None:
    """Start listening to Blender's events, and trace the scenes that are shown."""
    _HANDLERS.add()
    live_output.register()
    _trace_soon()


def unregister() -> None:
    """Stop listening, cancel running work, and drop all state."""
    job.stop()
    for timer in (trace_opened, _read_postponed):
        if bpy.app.timers.is_registered(timer):
            bpy.app.timers.unregister(timer)
    live_output.unregister()
    _HANDLERS.remove()
    file_changed()
    events.disabled()
