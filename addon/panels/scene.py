"""Panel "Haptic Tracing": what one listener feels, why, and the buttons that play."""

from __future__ import annotations

from bpy.types import Context

from ..gateway import is_loaded
from ..live_output import handlers, preview
from ..view import watched
from .answer import draw_answer, draw_remedy_of_cause, draw_why
from .drawing import SidebarPanel


class HAPTIC_PT_scene(SidebarPanel):
    bl_label = "Haptic Tracing"
    bl_order = 0

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.haptics, "tracing", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        draw_answer(layout, context)
        playing = context.screen is not None and context.screen.is_animation_playing
        row = layout.row(align=True)
        row.operator(
            "screen.animation_play",
            text="Pause" if playing else "Play",
            icon="PAUSE" if playing else "PLAY",
        )
        heard = handlers.may_hear() or (is_loaded(preview) and preview.is_on())
        if watched.levels_of(context.scene):
            row.operator("haptic.toggle_preview", text="", icon="SPEAKER", depress=heard)


class HAPTIC_PT_why(SidebarPanel):
    bl_parent_id = "HAPTIC_PT_scene"
    bl_label = "Why"
    bl_ui_units_x = 14
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header_preset(self, context: Context) -> None:
        draw_remedy_of_cause(self.layout, context)

    def draw(self, context: Context) -> None:
        draw_why(self.layout, context)
