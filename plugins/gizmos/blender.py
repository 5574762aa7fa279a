"""Gizmos in the viewport: circles for the amplitude of a source and the radius of a listener, each
with a handle; and what is under the mouse in the overlay."""

from __future__ import annotations

import math
from typing import Any

import bpy
from bpy.types import Context, Gizmo, GizmoGroup, SpaceView3D
from mathutils import Matrix

from ...addon.blender.polling import is_editable
from ...addon.blender.units import metres_per_unit
from ...addon.gateway import StandIn, is_loaded
from ...addon.session import sessions
from ...addon.view import meters, overlay

inspection = StandIn(f"{__package__}.inspection")

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
        circle = self.gizmos.new("GIZMO_GT_dial_3d")
        handle = self.gizmos.new("GIZMO_GT_arrow_3d")
        circle.use_draw_scale, circle.hide_select = False, True
        handle.draw_style, handle.length, handle.scale_basis = "BOX", 0.0, 1.2
        handle.use_draw_modal = handle.use_undo = True
        circle.color = handle.color = colour
        handle.color_highlight = 1.0, 1.0, 1.0

        def pulled(value: Any) -> None:
            held = getattr(bpy.context.object.haptics, role)
            setattr(held, name, max(value, 0.0) * metres_per_unit(bpy.context.scene))

        handle.target_set_handler(
            "offset",
            get=lambda: (
                getattr(getattr(bpy.context.object.haptics, role), name)
                / metres_per_unit(bpy.context.scene)
            ),
            set=pulled,
        )
        return circle, handle

    def draw_prepare(self, context: Context) -> None:
        facing = context.region_data.view_matrix.inverted().to_3x3().to_4x4()
        place = Matrix.Translation(context.object.matrix_world.translation) @ facing
        for role, name, turn, circle, handle in self.pairs:
            properties = getattr(context.object.haptics, role)
            circle.hide = handle.hide = not properties.enabled
            radius = max(getattr(properties, name), 1e-3) / metres_per_unit(context.scene)
            circle.matrix_basis = place @ Matrix.Scale(radius, 4)
            handle.matrix_basis = place @ Matrix.Rotation(turn * math.pi, 4, "Y")


class HAPTIC_GT_inspection(Gizmo):
    """The connection or listener under the mouse; a click selects its object and shows Why"""

    bl_idname = "HAPTIC_GT_inspection"

    def setup(self) -> None:
        self.mouse = 0.0, 0.0
        self.link: Any = None

    def draw(self, context: Any) -> None:
        # What is drawn here would be under the labels.
        hovered = (self.link, self.mouse) if self.is_highlight and self.link is not None else None
        inspection.hovered[context.region.as_pointer()] = hovered

    def test_select(self, context: Any, location: Any) -> int:
        before = self.link
        self.link = inspection.under(context, location)
        if self.link is not None:
            self.mouse = float(location[0]), float(location[1])
        if self.link is not before:
            context.region.tag_redraw()
        return -1 if self.link is None else 0

    def invoke(self, context: Any, event: Any) -> set[str]:
        target = meters.target_under(context, self.mouse)
        if target is not None and target.switch:
            meters.switch(target.listener, target.switch)
            bpy.ops.ed.undo_push(message="Solo" if target.switch == "S" else "Mute")
            return {"FINISHED"}
        own = sessions.known(context.scene)
        if own is not None:
            own.watched.active = self.link.listener
        bpy.ops.haptic.select_object("EXEC_DEFAULT", True, name=self.link.first, extend=event.shift)
        if target is None:
            bpy.ops.wm.call_panel(name="HAPTIC_PT_why")
        return {"FINISHED"}

    def modal(self, context: Any, event: Any, tweak: Any) -> set[str]:
        """Never called; Blender calls ``invoke`` only where this is there, too."""
        return {"FINISHED"}


class HAPTIC_GGT_inspection(GizmoGroup):
    """Tooltips of the haptic graph"""

    bl_idname = "HAPTIC_GGT_inspection"
    bl_label = "Haptic Inspection"
    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options = {"PERSISTENT"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        haptics = context.scene.haptics
        overlay = context.space_data.overlay.show_overlays and (
            haptics.show_overlay or haptics.meters.show
        )
        return overlay and context.mode == "OBJECT" and sessions.shown(context.scene) is not None

    def setup(self, context: Context) -> None:
        self.gizmos.new("HAPTIC_GT_inspection")


CLASSES = (HAPTIC_GGT_extents, HAPTIC_GT_inspection, HAPTIC_GGT_inspection)


def _draw() -> None:
    """Over the overlay's labels."""
    context = bpy.context
    if is_loaded(inspection) and overlay.is_shown(context) and sessions.shown(context.scene):
        inspection.draw(context)


_drawing: list[Any] = []


def register() -> None:
    _drawing.append(SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    while _drawing:
        SpaceView3D.draw_handler_remove(_drawing.pop(), "WINDOW")
