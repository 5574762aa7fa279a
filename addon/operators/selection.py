"""Operators that select an object."""

from __future__ import annotations

from typing import Any

from bpy.app.translations import pgettext_rpt as _rpt
from bpy.props import BoolProperty, StringProperty
from bpy.types import Context, Operator

from ..blender.polling import UNDO, poll_object_mode, refuse


class HAPTIC_OT_select_object(Operator):
    """Select the object and make it active"""

    bl_idname = "haptic.select_object"
    bl_label = "Select Object"
    bl_options = {*UNDO, "INTERNAL"}

    name: StringProperty(name="Object", description="Name of the object", options={"SKIP_SAVE"})
    extend: BoolProperty(name="Extend", description="Keep what is selected", default=False, options={"SKIP_SAVE"})

    poll = classmethod(poll_object_mode)

    def execute(self, context: Context) -> set[str]:
        found: Any = next((obj for obj in context.view_layer.objects if obj.name_full == self.name), None)
        if found is None:
            return refuse(self, _rpt("There is no object '{}' in this view layer any more").format(self.name), "WARNING")
        if not self.extend:
            for obj in context.selected_objects:
                obj.select_set(False)
        found.select_set(True)
        context.view_layer.objects.active = found
        return {"FINISHED"}
