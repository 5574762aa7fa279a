"""Panel "Haptic Tracing": quick start, how a scene is traced and shown, and what is wrong with it."""

from __future__ import annotations

from bpy.types import Context, Panel, Scene

from ..session import sessions
from .drawing import HapticsPanel, draw_problems


class HAPTIC_PT_scene(HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_scene"
    bl_label = "Haptic Tracing"
    bl_order = 0

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.haptics, "tracing", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        column = layout.column(align=True)
        column.operator("haptic.make_objects", icon="OUTLINER_OB_META")
        column.operator("haptic.add_source", icon="OUTLINER_OB_FORCE_FIELD")
        column.operator("haptic.add_listener", icon="OUTLINER_OB_LIGHTPROBE")
        column.operator("haptic.add_default_listeners", icon="OUTLINER_OB_ARMATURE")
        row = layout.row(align=True)
        playing = context.screen is not None and context.screen.is_animation_playing
        row.operator("screen.animation_play", text="Pause" if playing else "Play", icon="PAUSE" if playing else "PLAY")
        row.menu("HAPTIC_MT_samples")
        layout.label(text=next_step(context.scene), icon="INFO")
        draw_problems(layout, context)


def next_step(scene: Scene) -> str:
    """What to do next on the way to something that is felt."""
    traced = sessions.shown(scene)
    result = None if traced is None else traced.result
    if not scene.haptics.tracing:
        return "Switch tracing on, above"
    if result is None or not result.objects:
        if sessions.shown_problems(scene):
            return "Mend the problem below"
        return "Select objects: Make Haptic"
    if not result.sources and not scene.haptics.impacts:
        return "Select what vibrates: Add Source"
    if not result.listeners:
        return "Select what feels: Add Listener"
    return "Press play"


class HAPTIC_PT_propagation(HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_propagation"
    bl_parent_id = "HAPTIC_PT_scene"
    bl_label = "Propagation"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        haptics = context.scene.haptics
        layout.prop(haptics, "mode")
        row = layout.row()
        row.active = haptics.mode == "HT"
        row.prop(haptics, "localise", slider=True)
        layout.prop(haptics, "strategy")
        column = layout.column(align=True)
        column.prop(haptics, "threshold")
        column.prop(haptics, "max_connections")
        column.prop(haptics, "epsilon")
        column = layout.column(align=True)
        column.prop(haptics, "contact_tolerance")
        column.prop(haptics, "patch_points")


class HAPTIC_PT_impacts(HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_impacts"
    bl_parent_id = "HAPTIC_PT_scene"
    bl_label = "Impacts"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.haptics, "impacts", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        haptics = context.scene.haptics
        layout.active = haptics.impacts
        layout.prop(haptics, "impact_signal")
        column = layout.column(align=True)
        column.prop(haptics, "minimum_energy")
        column.prop(haptics, "maximum_energy")
        column.prop(haptics, "impact_energy")
        column.prop(haptics, "refractory_time")


class HAPTIC_PT_overlay(HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_overlay"
    bl_parent_id = "HAPTIC_PT_scene"
    bl_label = "Overlay"
    bl_translation_context = "Haptics"  # Blender's own word for it is that of mixing colours
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.haptics, "show_overlay", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        haptics = context.scene.haptics
        layout.active = haptics.show_overlay
        column = layout.column(align=True)
        column.prop(haptics, "show_intra")
        column.prop(haptics, "show_best_paths")
        column.prop(haptics, "show_labels")
        column.prop(haptics, "show_flow")
        column.prop(haptics, "xray")
        layout.operator("haptic.graph_to_geometry", icon="MESH_DATA")


CLASSES = (HAPTIC_PT_scene, HAPTIC_PT_propagation, HAPTIC_PT_impacts, HAPTIC_PT_overlay)
