"""Operators that trace."""

from __future__ import annotations

from bpy.app.translations import pgettext_rpt as _rpt
from bpy.types import Context, Operator

from ..blender.polling import refuse
from ..changes.redraw import redraw_viewports
from ..session import session, sessions, worker


class HAPTIC_OT_trace_frame(Operator):
    """Trace the current frame again, reading everything anew"""

    bl_idname = "haptic.trace_frame"
    bl_label = "Trace This Frame"

    def execute(self, context: Context) -> set[str]:
        session.of(context.scene).reader.forget_shapes()
        session.begin(context.scene, context.evaluated_depsgraph_get())
        if not session.is_busy(context.scene, worker.MOMENT) and session.result_of(context.scene) is None:
            problems = session.problems_of(context.scene)
            nothing = "Nothing is tagged: select objects and press Make Haptic"
            return refuse(self, problems[0].message if problems else _rpt(nothing), "WARNING")
        redraw_viewports()
        return {"FINISHED"}


class HAPTIC_OT_toggle_tracing(Operator):
    """Switch tracing on or off"""

    bl_idname = "haptic.toggle_tracing"
    bl_label = "Toggle Tracing"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: Context) -> set[str]:
        haptics = context.scene.haptics
        haptics.tracing = not haptics.tracing
        self.report({"INFO"}, "Tracing is on" if haptics.tracing else "Tracing is off")
        redraw_viewports()
        return {"FINISHED"}


class HAPTIC_OT_cancel_tracing(Operator):
    """Stop tracing this frame. The next edit or frame is traced as always; switch tracing off to edit without waiting"""

    bl_idname = "haptic.cancel_tracing"
    bl_label = "Cancel Tracing"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return sessions.is_behind(context.scene)

    def execute(self, context: Context) -> set[str]:
        session.give_up()
        redraw_viewports()
        return {"FINISHED"}
