"""Blender's events: frames are played on the devices while the timeline runs; any other event
silences them."""

from __future__ import annotations

import atexit
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.handlers import persistent
from bpy.types import Scene

from ..blender.full_names import object_named
from ..blender.handlers import Handlers
from ..blender.time import frame_seconds, seconds_of
from ..changes import revisions
from ..changes.events import device_adjusted, preview_adjusted
from ..gateway import is_loaded
from ..properties.live_output import HapticDeviceProperties, HapticLiveOutputProperties
from ..properties.preferences import preferences
from ..session import session, sessions
from . import outputs, player, preview, refresh

if TYPE_CHECKING:
    from concurrent.futures import Future


@dataclass(slots=True)
class _PlaybackState:
    """State of live output.

    Attributes:
        started: session id of the scene that plays, and the time at which playback began [s]; None
            while nothing plays.
        restored: session id of a scene, and the frame to which Blender returns after a render;
            until the next frame.
        hears: whether the preview is to begin with the next frame in which something is felt, and
            whether it has begun in this way.
    """

    started: tuple[int, float] | None = None
    restored: tuple[int, int] | None = None
    hears: tuple[bool, bool] = (False, False)


_state = _PlaybackState()


def _is_used() -> bool:
    """Whether live output has been used: a search for devices, or the preview. Its modules are
    loaded then."""
    return is_loaded(outputs) or is_loaded(preview)


def may_hear() -> bool:
    """Whether what is felt is heard by itself: the user's wish, in a Blender with windows."""
    return preferences().hear and not bpy.app.background


def is_new() -> bool:
    """Whether the preview has begun by itself for the first time."""
    return _state.hears[1] and not preferences().was_told


def _begin_to_hear(scene: Scene) -> None:
    """Switch the preview on if something is felt, and no device plays it."""
    traced = sessions.shown(scene)
    if traced is None or not traced.result.amplitudes.any() or outputs.running():
        return
    try:
        preview.switch_on()
    except preview.AudioUnavailable:
        _state.hears = False, False
        return
    preview.adjust(scene.haptics.live_output)
    _state.hears = False, True


def is_wanted(scene: Scene) -> bool:
    """Whether there is any output; starts a player that was loaded during playback."""
    if _state.hears[0]:
        _begin_to_hear(scene)
    if not _is_used() or not player.is_wanted():
        return False
    if _state.started is not None and not player.is_playing():
        player.start(*_state.started)
    return True


def frame_comes(scene: Scene) -> None:
    """If tracing takes long, play a frame before it is traced, with the gains of the last traced
    frame."""
    traced = sessions.shown(scene) if is_wanted(scene) else None
    if traced is not None:
        time = seconds_of(scene, scene.frame_current)
        player.play_ahead(
            scene.session_uid,
            traced.result,
            scene.frame_current,
            time,
            frame_seconds(scene),
            choices(traced.result),
        )


def frame_changed(scene: Scene, recorded: bool) -> None:
    """Play the frame that is being traced on the outputs when its trace is complete; silence if it
    cannot be traced, or if tracing is off. ``recorded``: the frame comes from a baked track."""
    restored, _state.restored = _state.restored, None
    if restored == (scene.session_uid, scene.frame_current) and not player.is_playing():
        player.rest()
        return
    try:
        begun = session.of(scene).begun if scene.haptics.tracing else None
        if begun is not None and player.went_ahead(scene.session_uid, scene.frame_current):
            begun.add_done_callback(_correct)
            return
        result = session.result_of(scene) if scene.haptics.tracing else None
        if result is None or result.number != scene.frame_current:
            player.rest()
            return
        player.play(scene.session_uid, result, frame_seconds(scene), choices(result), recorded)
    except Exception:
        player.rest()
        raise


def _correct(begun: Future[sessions.Traced]) -> None:
    """Correct a frame that was played ahead, after its trace; called on the worker."""
    if not begun.cancelled() and begun.exception() is None:
        player.correct(begun.result().result)


@persistent
def animation_playback_pre(scene: Scene, *_: Any) -> None:
    """Playback starts."""
    _state.started = scene.session_uid, seconds_of(scene, scene.frame_current)
    _state.hears = may_hear() and not (is_loaded(preview) and preview.is_on()), False
    # What plays is loaded now, not at the first frame in which something is felt.
    if _is_used() or (_state.hears[0] and sessions.known(scene) is not None):
        player.start(*_state.started)


@persistent
def animation_playback_post(*_: Any) -> None:
    """Playback was stopped or paused."""
    _state.started = None
    if _is_used():
        player.stop()
    if _state.hears[1]:
        preview.switch_off()
        preferences().was_told = True
    _state.hears = False, False


@persistent
def rest(*_: Any) -> None:
    """An event other than a frame: silence until the next frame."""
    if _is_used():
        player.rest()


@persistent
def render_ends(scene: Scene, *_: Any) -> None:
    """After a render: Blender changes to the frame from before, which nobody has moved to."""
    _state.restored = scene.session_uid, scene.frame_current


@persistent
def load_pre(*_: Any) -> None:
    """Disconnect the devices, because another file with its own settings is loaded."""
    _state.started = None
    if _is_used():
        player.stop()
        outputs.disconnect_all()
        preview.switch_off()


def choices(result: Any) -> dict[str, str]:
    """The actuators chosen for the listeners of a frame, by name; without automatic choices. Cached
    until a change."""
    return _choices(revisions.actuators(), tuple(listener.name for listener in result.listeners))


@lru_cache(maxsize=1)
def _choices(revision: int, listeners: tuple[str, ...]) -> dict[str, str]:
    objects = ((name, object_named(name)) for name in listeners)
    found = {name: obj.haptics.live_output.actuators for name, obj in objects if obj is not None}
    return {name: actuators for name, actuators in found.items() if actuators}


@persistent
def choose_again(*_: Any) -> None:
    """Discard the cached choices after undo, redo and file load."""
    revisions.mark_actuators()


def adjust(settings: HapticDeviceProperties) -> None:
    """Apply a device's changed settings to its output."""
    output = outputs.running().get(settings.name) if _is_used() else None
    if output is not None:
        output.adjust(outputs.adjustment_of(settings, output.profile))


def adjust_preview(settings: HapticLiveOutputProperties) -> None:
    """Apply a scene's changed settings of the preview."""
    if is_loaded(preview):
        preview.adjust(settings)


@persistent
def stop_everything(*_: Any) -> None:
    """Silence and disconnect everything, waiting at most a second."""
    if not _is_used():
        return
    player.stop()
    preview.switch_off()
    outputs.stop_all()


_HANDLERS = Handlers(
    animation_playback_pre=animation_playback_pre,
    animation_playback_post=animation_playback_post,
    load_pre=load_pre,
    undo_pre=rest,
    redo_pre=rest,
    undo_post=choose_again,
    redo_post=choose_again,
    load_post=choose_again,
    render_pre=rest,
    render_complete=render_ends,
    render_cancel=render_ends,
    exit_pre=stop_everything,
)


def register() -> None:
    _HANDLERS.add()
    device_adjusted.subscribe(adjust)
    preview_adjusted.subscribe(adjust_preview)
    atexit.register(stop_everything)
    choose_again()


def unregister() -> None:
    device_adjusted.unsubscribe(adjust)
    preview_adjusted.unsubscribe(adjust_preview)
    atexit.unregister(stop_everything)
    _HANDLERS.remove()
    stop_everything()
    if _is_used():
        outputs.forget()
    refresh.stop()
