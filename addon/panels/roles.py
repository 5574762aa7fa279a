"""Panel "Selected Object": its roles, with the values that matter first."""

from __future__ import annotations

from typing import Any

from bpy.types import Context, UILayout

from ..authoring import body_kit
from ..blender.words import show
from ..view import watched
from .drawing import SidebarPanel, draw_each
from .object import draw_override, draw_transmission
from .source import draw_signal


class HAPTIC_PT_roles(SidebarPanel):
    bl_label = "Selected Object"
    bl_order = 10

    def draw(self, context: Context) -> None:
        layout = self.layout
        obj = context.object
        if obj is None:
            layout.label(text="Select an object", icon="INFO")
            return
        row = layout.row()
        show(row, obj.name, "OBJECT_DATA")
        draw_override(layout, obj)
        haptics = obj.haptics
        several = len(context.selected_objects) > 1
        if obj.type == "ARMATURE":
            layout.prop(haptics, "body")
            if not any(skin.haptics.enabled for skin in body_kit.skins(obj)):
                layout.operator("haptic.make_objects", icon="OUTLINER_OB_META")
        elif _draw_role(
            layout, haptics, "object", "haptic.make_objects", "OUTLINER_OB_META", several
        ):
            draw_transmission(layout.column(align=True), context, obj)
        if _draw_role(
            layout, haptics.source, "source", "haptic.add_source", "OUTLINER_OB_FORCE_FIELD"
        ):
            draw_signal(layout.column(align=True), haptics.source)
        else:
            layout.operator("haptic.import_sound", icon="FILE_SOUND")
        if _draw_role(
            layout,
            haptics.listener,
            "listener",
            "haptic.add_listener",
            "OUTLINER_OB_LIGHTPROBE",
            several,
        ):
            draw_each(layout.column(align=True), haptics.listener, "body_part", "gain")
        armature = body_kit.armature_of(obj)
        has_body = (
            any(level.body_part for level in watched.levels_of(context.scene))
            if armature is None
            else body_kit.listeners_on(armature)
        )
        if not has_body and not haptics.listener.enabled:
            layout.operator("haptic.add_default_listeners", icon="OUTLINER_OB_ARMATURE")
        if armature is not None:
            layout.operator("haptic.add_footsteps", icon="MOD_DYNAMICPAINT")


def _draw_role(
    layout: UILayout, role: Any, name: str, operator: str, icon: str, several: bool = False
) -> bool:
    """Draw a role of the active object. Returns whether it has it.

    Args:
        role: The properties of the role.
        name: The name of the panel with all its values, which a button opens; Blender draws the
            switch of the panel's header beside the button.
        operator: Gives the role.
        icon: Of the operator.
        several: The role can be given to other selected objects, too.
    """
    if not role.enabled:
        layout.operator(operator, icon=icon)
        return False
    row = layout.row(align=True)
    row.label(text=role.bl_rna.properties["enabled"].name, icon=icon)
    if several:
        row.operator(operator, text="", icon="ADD")
    row.popover(f"HAPTIC_PT_{name}", text="", icon="PREFERENCES")
    return True
