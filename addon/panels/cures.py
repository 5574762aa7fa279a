"""Buttons and fields that remove a reason for silence."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import bpy
from bpy.types import Context, UILayout

from ...core.message import Cause, Message
from .drawing import select_button
from .texts import fitted


def draw_cure(layout: UILayout, context: Context, reason: Message) -> None:
    """Draw the button or field that removes the reason, if there is one."""
    draw = _CURES.get(reason.cause)
    if draw is not None:
        draw(layout, context, reason)
    if reason.object and reason.cause not in _COMPLETE:
        select_button(layout, reason.object, fitted(reason.object, icon=True), icon="RESTRICT_SELECT_OFF")


def _add_source(layout: UILayout, context: Context, reason: Message) -> None:
    layout.operator("haptic.add_source", icon="OUTLINER_OB_FORCE_FIELD")


def _play(layout: UILayout, context: Context, reason: Message) -> None:
    layout.operator("screen.animation_play", text="Play", icon="PLAY")


def _restart(layout: UILayout, context: Context, reason: Message) -> None:
    layout.operator("screen.frame_jump", text="Jump to First Frame", icon="REW").end = False


def _use_mode(layout: UILayout, context: Context, reason: Message) -> None:
    layout.operator("haptic.set_mode", text="Set Mode to HT").mode = "HT"


def _of_scene(name: str) -> Callable[[UILayout, Context, Message], None]:
    def draw(layout: UILayout, context: Context, reason: Message) -> None:
        layout.prop(context.scene.haptics, name)

    return draw


def _of_object(role: str, name: str) -> Callable[[UILayout, Context, Message], None]:
    def draw(layout: UILayout, context: Context, reason: Message) -> None:
        obj = bpy.data.objects.get(reason.object)
        if obj is not None:
            owner: Any = getattr(obj.haptics, role) if role else obj.haptics
            layout.prop(owner, name)

    return draw


_CURES: Mapping[Cause, Callable[[UILayout, Context, Message], None]] = {
    Cause.NO_SOURCE: _add_source,
    Cause.MUTED: _of_object("source", "muted"),
    Cause.ZERO_AMPLITUDE: _of_object("source", "amplitude"),
    Cause.FINISHED: _restart,
    Cause.NEAREST_LISTENER_ONLY: _use_mode,
    Cause.LOCALISED: _of_scene("localise"),
    Cause.LISTENER_GAIN: _of_object("listener", "gain"),
    Cause.NOT_RENDERED: _play,
    Cause.PAUSE: _play,
    Cause.NOT_FELT: _of_object("source", "amplitude"),
    Cause.NARROW_GAP: _of_scene("contact_tolerance"),
    Cause.BELOW_THRESHOLD: _of_scene("threshold"),
    Cause.TOO_FAR: _of_scene("threshold"),
    Cause.TOO_LONG: _of_scene("max_connections"),
    Cause.NO_CONNECTION_ALLOWED: _of_scene("max_connections"),
}
_COMPLETE = {Cause.MUTED, Cause.ZERO_AMPLITUDE, Cause.LISTENER_GAIN, Cause.NO_SOURCE, Cause.NOT_RENDERED, Cause.PAUSE}
"""Causes whose remedy needs no selection of an object."""
