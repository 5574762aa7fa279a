"""Operators that select an object."""

from __future__ import annotations

from typing import Any

from bpy.app.translations import pgettext_rpt as _rpt
from bpy.props import BoolProperty, StringProperty
from bpy.types import Context, Operator

from ..blender.polling import UNDO, Edit, Refused


class HAPTIC_OT_select_object(Edit, Operator):
    """Select the object and make it active"""

    bl_label = "Select Object"
    bl_options = {*UNDO, "INTERNAL"}

    name: StringProperty(name="Object", description="Name of the object", options={"SKIP_SAVE"})
    extend: BoolProperty(name="Extend", description="Keep what is selected", default=False, options={"SKIP_SAVE"})

    def apply(self, context: Context) -> None:
        found: Any = next((obj for obj in context.view_layer.objects if obj.name_full == self.name), None)
        if found is None:
            raise Refused(_rpt("There is no object '{}' in this view layer any more").format(self.name))
        if not self.extend:
            for obj in context.selected_objects:
                obj.select_set(False)
        found.select_set(True)
        context.view_layer.objects.active = found
