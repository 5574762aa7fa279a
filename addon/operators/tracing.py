"""Operators that trace, and that stop it."""

from __future__ import annotations

from bpy.types import Context

from ..blender.polling import Action, Refused
from ..changes.redraw import redraw_viewports
from ..scene_reader.problem import why_untraced
from ..session import session, sessions, worker


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
