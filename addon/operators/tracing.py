"""Operators that trace."""

from __future__ import annotations

from bpy.app.translations import pgettext_rpt as _rpt
from bpy.types import Context, Operator

from ..blender.polling import Action, Edit, Refused
from ..changes.redraw import redraw_viewports
from ..session import session, sessions, worker


class HAPTIC_OT_trace_frame(Action, Operator):
    """Trace the current frame again, reading everything anew"""

    bl_label = "Trace This Frame"

    def apply(self, context: Context) -> None:
        session.of(context.scene).reader.forget_shapes()
        session.begin(context.scene, context.evaluated_depsgraph_get())
        if not session.is_busy(context.scene, worker.MOMENT) and session.result_of(context.scene) is None:
            problems = session.problems_of(context.scene)
            nothing = "Nothing is tagged: select objects and press Make Haptic"
            raise Refused(problems[0].message if problems else _rpt(nothing))
        redraw_viewports()


class HAPTIC_OT_toggle_tracing(Edit, Operator):
    """Switch tracing on or off"""

    bl_label = "Toggle Tracing"

    def apply(self, context: Context) -> None:
        haptics = context.scene.haptics
        haptics.tracing = not haptics.tracing
        self.report({"INFO"}, "Tracing is on" if haptics.tracing else "Tracing is off")
        redraw_viewports()


class HAPTIC_OT_cancel_tracing(Action, Operator):
    """Stop tracing this frame. The next edit or frame is traced as always; switch tracing off to edit without waiting"""

    bl_label = "Cancel Tracing"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return sessions.is_behind(context.scene)

    def apply(self, context: Context) -> None:
        session.give_up()
        redraw_viewports()
