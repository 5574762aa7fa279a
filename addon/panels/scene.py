"""Panel "Haptic Tracing": the summary of one listener, the next step, problems, and the settings of
tracing and display."""

from __future__ import annotations

from functools import partial
from typing import Any

from bpy.types import Context, Panel, UILayout

from ...core.scene.impact_rule import CURVES, ImpactLimits, ImpactRule
from ...core.scene.rules import ContactSettings
from ...core.scene.texture import Texture
from ...core.scene.values import Settings
from ..blender.documentation import page_url
from ..properties.scene import HapticSceneProperties
from ..scene_reader import roles
from ..session import sessions
from .answer import draw_answer, draw_progress
from .drawing import (
    ClosedPanel,
    HapticsPanel,
    draw_held,
    draw_problems,
    draw_properties,
    settings_layout,
)
from .formula import draw_parameters
from .hints import draw_hint
from .materials import draw_models
from .rules import draw_table


class HAPTIC_PT_scene(HapticsPanel, Panel):
    bl_label = "Haptic Tracing"
    bl_order = 0

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.haptics, "tracing", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        draw_progress(layout, context)
        draw_answer(layout, context)
        if sessions.shown(context.scene) is None and not roles.is_any_tagged(context.scene):
            _draw_card(layout)
        draw_hint(layout, context)
        draw_problems(layout, context)
        column = layout.column(align=True)
        column.operator("haptic.make_objects", icon="OUTLINER_OB_META")
        column.operator("haptic.add_source", icon="OUTLINER_OB_FORCE_FIELD")
        column.operator("haptic.add_listener", icon="OUTLINER_OB_LIGHTPROBE")
        column.operator("haptic.add_default_listeners", icon="OUTLINER_OB_ARMATURE")
        row = layout.row(align=True)
        playing = context.screen is not None and context.screen.is_animation_playing
        row.operator(
            "screen.animation_play",
            text="Pause" if playing else "Play",
            icon="PAUSE" if playing else "PLAY",
        )
        row.menu("HAPTIC_MT_samples")


def _draw_card(layout: UILayout) -> None:
    """Draw the entries for newcomers."""
    box = layout.box()
    box.label(text="New here? Look, try, or read", icon="HEART")
    column = box.column(align=True)
    column.menu("HAPTIC_MT_samples", icon="SCENE_DATA")
    column.operator("wm.url_open", text="Quick Start", icon="PLAY").url = page_url("tutorial")
    column.operator("wm.url_open", text="Documentation", icon="HELP").url = page_url("index")


class HAPTIC_PT_propagation(ClosedPanel, Panel):
    bl_parent_id = "HAPTIC_PT_scene"
    bl_label = "Propagation"

    def draw(self, context: Context) -> None:
        layout = settings_layout(self)
        haptics = context.scene.haptics
        draw_held(
            layout,
            haptics,
            Settings,
            strategy=partial(_draw_strategy, haptics),
            localise=partial(_draw_localise, haptics),
        )


def _draw_strategy(haptics: HapticSceneProperties, layout: UILayout) -> None:
    layout.prop(haptics, "strategy")
    draw_models(layout)


def _draw_localise(haptics: HapticSceneProperties, layout: UILayout) -> None:
    row = layout.row()
    row.active = haptics.mode == "HT"
    row.prop(haptics, "localise", slider=True)


class HAPTIC_PT_impacts(ClosedPanel, Panel):
    bl_parent_id = "HAPTIC_PT_scene"
    bl_label = "Impacts"

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.haptics, "impacts", text="")

    def draw(self, context: Context) -> None:
        layout = settings_layout(self)
        haptics = context.scene.haptics
        layout.active = haptics.impacts
        draw_held(layout, haptics, ContactSettings, impacts=None, tolerance=None)


class HAPTIC_PT_impact_table(ClosedPanel, Panel):
    bl_parent_id = "HAPTIC_PT_impacts"
    bl_label = "Rules"
    bl_description = (
        "What impacts between some objects need and play, in place of what is said "
        "above; the most specific rule counts"
    )

    def draw(self, context: Context) -> None:
        layout = settings_layout(self)
        layout.active = context.scene.haptics.impacts
        rule = draw_table(layout, context, "impact_table")
        if rule is None:
            return
        layout.prop(rule, "template")
        if rule.template == "FILE":
            layout.prop(rule, "filepath")
        if rule.template == "DRAWN":
            layout.prop(rule, "drawing")
        layout.prop(rule, "use_limits")
        if rule.use_limits:
            draw_held(layout.column(align=True), rule, ImpactLimits)
        curves = {curve: partial(_draw_curve, rule, curve) for curve in CURVES}
        draw_held(layout, rule, ImpactRule, seed=partial(_draw_seed, rule), **curves)


def _draw_curve(rule: Any, curve: str, layout: UILayout) -> None:
    column = layout.column(align=True)
    column.prop(rule, curve, index=0)
    column.prop(rule, curve, index=1, text="at Full Energy")


def _draw_seed(rule: Any, layout: UILayout) -> None:
    if rule.variation:
        layout.prop(rule, "seed")


class HAPTIC_PT_textures(ClosedPanel, Panel):
    bl_parent_id = "HAPTIC_PT_scene"
    bl_label = "Sliding and Rolling"
    bl_description = (
        "Textures of objects that slide or roll on each other; none without a "
        "matching rule, and the most specific rule counts"
    )

    def draw(self, context: Context) -> None:
        layout = settings_layout(self)
        layout.operator("haptic.add_textures", icon="MATERIAL")
        rule = draw_table(layout, context, "textures")
        if rule is None:
            return
        draw_held(layout.column(align=True), rule, Texture)


class HAPTIC_PT_contacts(ClosedPanel, Panel):
    bl_parent_id = "HAPTIC_PT_scene"
    bl_label = "Contacts"
    bl_description = (
        "What contacts between some objects pass on; everything where no rule fits, "
        "the most specific rule counts"
    )

    def draw(self, context: Context) -> None:
        layout = settings_layout(self)
        haptics = context.scene.haptics
        layout.prop(haptics, "contact_tolerance")
        rule = draw_table(layout, context, "transmission_table")
        if rule is not None:
            layout.prop(rule, "function")
            draw_parameters(layout, rule, 0.0, 1.0, haptics.epsilon, on_contact=True)


class HAPTIC_PT_overlay(ClosedPanel, Panel):
    bl_parent_id = "HAPTIC_PT_scene"
    bl_label = "Overlay"
    bl_translation_context = (
        "Haptics"  # Blender's translation of the word is that of mixing colours
    )

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.haptics, "show_overlay", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        haptics = context.scene.haptics
        layout.active = haptics.show_overlay
        draw_properties(
            layout, haptics, "show_intra", "show_best_paths", "show_labels", "show_flow", "xray"
        )
        layout.operator("haptic.graph_to_geometry", icon="MESH_DATA")
