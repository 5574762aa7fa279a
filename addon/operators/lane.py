"""Operator that moves one-shots in the lane over timelines."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Event, Operator

from ..blender.polling import is_editable
from ..blender.words import report_text
from ..gateway import is_loaded
from ..view import lane


class HAPTIC_OT_drag_one_shot(Operator):
    """Move a one-shot in time; it snaps to impacts and markers, and with Ctrl to whole frames"""

    bl_idname = "haptic.drag_one_shot"
    bl_label = "Move One-Shot"
    bl_options = {"UNDO", "INTERNAL"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        area = context.area
        return is_loaded(lane) and area is not None and area.type == "DOPESHEET_EDITOR"

    def invoke(self, context: Context, event: Event) -> set[str]:
        mark = lane.under(context, (event.mouse_region_x, event.mouse_region_y))
        if mark is None or not is_editable(bpy.data.objects[mark.source]):
            return {"PASS_THROUGH"}
        self.mark, self.frame = mark, mark.frame
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        is_over = event.type in {"RIGHTMOUSE", "ESC"}
        if event.type == "MOUSEMOVE":
            x, view = event.mouse_region_x, context.region.view2d
            frame = round(view.region_to_view(x, 0)[0]) if event.ctrl else lane.snap(context, x)
            self._put(context, float(frame))
            context.area.header_text_set(report_text("One-shot at frame {:g}", round(frame, 2)))
        elif is_over:
            self._put(context, self.mark.frame)
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self._curve().update()
            is_over = True
        if not is_over:
            return {"RUNNING_MODAL"}
        context.area.header_text_set(None)
        return {"CANCELLED"} if self.frame == self.mark.frame else {"FINISHED"}

    def _curve(self) -> Any:
        return lane.trigger_curve(bpy.data.objects[self.mark.source])

    def _put(self, context: Context, frame: float) -> None:
        self.frame = self._curve().keyframe_points[self.mark.key].co_ui[0] = frame
        context.area.tag_redraw()
