"""Buttons and fields that remove a problem or a reason for silence."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.types import Context, UILayout

from ...core.message import Cause, Message
from .drawing import select_button
from .texts import fitted

if TYPE_CHECKING:
    from ..properties.source import HapticSourceProperties
    from ..scene_reader.problem import Problem


def draw_cure(layout: UILayout, context: Context, reason: Message) -> bool:
    """Draw the button or field that removes the reason, or the button that selects its object.
    Returns False if there is none."""
    obj = bpy.data.objects.get(reason.object)
    haptics = context.scene.haptics
    match reason.cause:
        case Cause.NO_SOURCE:
            layout.operator("haptic.add_source", icon="OUTLINER_OB_FORCE_FIELD")
        case Cause.FINISHED:
            layout.operator("screen.frame_jump", text="Jump to First Frame", icon="REW").end = False
        case Cause.NEAREST_LISTENER_ONLY:
            layout.prop_enum(haptics, "mode", "HT", text="Set Mode to Haptic Tracing")
        case Cause.NARROW_GAP:
            layout.prop(haptics, "contact_tolerance", text="Tolerance")
        case Cause.MUTED if obj is not None:
            layout.prop(obj.haptics.source, "muted")
        case Cause.ZERO_AMPLITUDE | Cause.NOT_FELT if obj is not None:
            layout.prop(obj.haptics.source, "amplitude")
        case Cause.LISTENER_GAIN if obj is not None:
            layout.prop(obj.haptics.listener, "gain")
        case _ if reason.object:
            _draw_selection(layout, reason.object)
        case _:
            return False
    return True


def _draw_selection(layout: UILayout, name: str) -> None:
    """Draw the button that selects an object."""
    title = fitted(name, 0.5, icon=True, button=True)
    select_button(layout, name, title, icon="RESTRICT_SELECT_OFF")


def draw_remedy(layout: UILayout, context: Context, problem: Problem) -> bool:
    """Draw the field that removes a problem, or the button that selects its object. Returns False
    if it has none."""
    obj = bpy.data.objects.get(problem.object)
    if problem.rule == ("signal", 0) and obj is not None and obj == context.object:
        draw_file(layout, obj.haptics.source)
    elif problem.object:
        _draw_selection(layout, problem.object)
    return bool(problem.object)


def draw_file(layout: UILayout, source: HapticSourceProperties) -> None:
    """Draw what a source plays where that is a file or a sound."""
    if source.signal == "FILE":
        layout.prop(source, "filepath", text="")
    elif source.signal == "SOUND":
        layout.operator("haptic.import_sound", icon="FILE_SOUND")
    else:
        layout.prop(source, "signal")
