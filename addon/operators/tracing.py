"""Operators that trace, and that switch between the haptic modes."""

from __future__ import annotations

from bpy.types import Context

from ...core.scene.values import MODES
from ..blender.polling import UNDO, Action, Refused
from ..changes.redraw import redraw_viewports
from ..properties.kinds import choice
from ..scene_reader.problem import why_untraced
from ..session import session, sessions, worker

_ITEMS = (
    *((mode.value, *words) for mode, words in MODES.items()),
    ("NEXT", "Next", "The one after the current: HT, SD, MD, MN, HT"),
)


class HAPTIC_OT_trace_frame(Action):
    """Read the whole scene again and trace the current frame"""

    bl_label = "Trace This Frame"

    def apply(self, context: Context) -> None:
        session.of(context.scene).reader.forget_shapes()
        session.begin(context.scene, context.evaluated_depsgraph_get())
        if (
            not session.is_busy(context.scene, worker.MOMENT)
            and session.result_of(context.scene) is None
        ):
            raise Refused(why_untraced(session.problems_of(context.scene)))
        redraw_viewports()


class HAPTIC_OT_toggle_tracing(Action):
    """Switch tracing on or off"""

    bl_label = "Toggle Tracing"
    bl_options = UNDO

    def apply(self, context: Context) -> None:
        haptics = context.scene.haptics
        haptics.tracing = not haptics.tracing
        self.tell("Tracing is on" if haptics.tracing else "Tracing is off")
        redraw_viewports()


class HAPTIC_OT_cancel_tracing(Action):
    """Stop tracing this frame. The next edit or frame is traced as always; switch tracing off to edit without waiting"""

    bl_label = "Cancel Tracing"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return sessions.is_behind(context.scene)

    def apply(self, context: Context) -> None:
        session.give_up()
        redraw_viewports()


class HAPTIC_OT_set_mode(Action):
    """Render the scene in another way, to compare: through touching objects, at the nearest listener, by distance, or without fading"""

    bl_label = "Set Haptic Mode"
    bl_options = UNDO
    bl_property = "mode"

    mode: choice("Mode", "The rendering", _ITEMS, default="NEXT")

    def apply(self, context: Context) -> None:
        haptics = context.scene.haptics
        modes = list(map(str, MODES))
        following = modes[(modes.index(haptics.mode) + 1) % len(modes)]
        haptics.mode = following if self.mode == "NEXT" else self.mode
        if not haptics.tracing:  # else the edit is traced
            session.begin(context.scene, context.evaluated_depsgraph_get())
        redraw_viewports()
