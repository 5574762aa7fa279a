"""Gizmos in the viewport: circles for the amplitude of a source and the radius of a listener, each
with a handle."""

from __future__ import annotations

import math
from typing import Any

import bpy
from bpy.types import Context, GizmoGroup
from mathutils import Matrix

from ..blender.polling import is_editable

_ROLES = (
    ("source", "amplitude", (0.95, 0.42, 0.24), -0.5),
    ("listener", "radius", (0.33, 0.74, 0.42), 0.5),
)
"""Property group, property, colour, and the angle of the handle's arrow about the view's vertical
axis in half turns, from the view's depth: left for an amplitude, right for a radius. The circle of
an amplitude of 1 has a radius of a metre."""


class HAPTIC_GGT_extents(GizmoGroup):
    """Amplitude of the active source, extent of the active listener"""

    bl_idname = "HAPTIC_GGT_extents"
    bl_label = "Haptic Extents"
    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options = {"3D", "PERSISTENT", "SHOW_MODAL_ALL"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        obj = context.object
        if obj is None or not obj.select_get() or not is_editable(obj) or context.mode != "OBJECT":
            return False
        return obj.haptics.source.enabled or obj.haptics.listener.enabled

    def setup(self, context: Context) -> None:
        self.pairs = [
            (role, name, turn, *self._pair(role, name, colour))
            for role, name, colour, turn in _ROLES
        ]

    def _pair(self, role: str, name: str, colour: tuple[float, float, float]) -> tuple[Any, Any]:
        """The circle and the handle of a property of the active object."""
        circle, handle = self.gizmos.new("GIZMO_GT_dial_3d"), self.gizmos.new("GIZMO_GT_arrow_3d")
        circle.use_draw_scale, circle.hide_select = False, True
        handle.draw_style, handle.length, handle.scale_basis = "BOX", 0.0, 1.2
        handle.use_draw_modal = handle.use_undo = True
        circle.color = handle.color = colour
        handle.color_highlight = (1.0, 1.0, 1.0)

        def pulled(value: Any) -> None:
            setattr(getattr(bpy.context.object.haptics, role), name, max(value, 0.0))

        handle.target_set_handler(
            "offset",
            get=lambda: getattr(getattr(bpy.context.object.haptics, role), name),
            set=pulled,
        )
        return circle, handle

    def draw_prepare(self, context: Context) -> None:
        facing = context.region_data.view_matrix.inverted().to_3x3().to_4x4()
        place = Matrix.Translation(context.object.matrix_world.translation) @ facing
        for role, name, turn, circle, handle in self.pairs:
            properties = getattr(context.object.haptics, role)
            circle.hide = handle.hide = not properties.enabled
            circle.matrix_basis = place @ Matrix.Scale(max(getattr(properties, name), 1e-3), 4)
            handle.matrix_basis = place @ Matrix.Rotation(turn * math.pi, 4, "Y")
