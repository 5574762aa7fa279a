"""Panel "Haptics" in Properties > Scene: how a scene is traced and shown."""

from __future__ import annotations

from functools import partial
from typing import Any

from bpy.types import Context, Panel, UILayout

from ...core.declaration import shown
from ...core.scene.impact_rule import CURVES, ImpactRule
from ...core.scene.rules import ContactSettings
from ...core.scene.texture import Texture
from ...core.scene.values import Settings
from ..properties.scene import HapticSceneProperties
from .drawing import (
    ScenePanel,
    draw_each,
    draw_held,
    draw_properties,
    settings_layout,
)
from .formula import draw_parameters
from .materials import draw_models
from .rules import draw_table


class HAPTIC_PT_settings(Panel):
    bl_label = "Haptics"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "scene"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        layout = settings_layout(self)
        haptics = context.scene.haptics
        draw_held(
            layout,
            haptics,
            Settings,
            strategy=partial(_draw_strategy, haptics),
        )


def _draw_strategy(haptics: HapticSceneProperties, layout: UILayout) -> None:
    layout.prop(haptics, "strategy")
    draw_models(layout)


class HAPTIC_PT_impacts(ScenePanel):
    bl_label = "Impacts"
    bl_description = (
        "Impacts as sources; a rule says what impacts between some objects need and play in "
        "place of what is said above it, the most specific one counts"
    )

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.haptics, "impacts", text="")

    def draw(self, context: Context) -> None:
        layout = settings_layout(self)
        haptics = context.scene.haptics
        layout.active = haptics.impacts
        draw_held(layout, haptics, ContactSettings, impacts=None, tolerance=None)
        layout.label(text="Rules")
        rule = draw_table(layout, context, "impact_table")
        if rule is None:
            return
        layout.prop(rule, "template")
        if rule.template == "FILE":
            layout.prop(rule, "filepath")
        if rule.template == "DRAWN":
            layout.prop(rule, "drawing")
        layout.prop(rule, "full_energy")
        curves = {
            curve: partial(_draw_curve, rule, curve)
            for curve in CURVES
            if curve in shown(ImpactRule)
        }
        draw_held(layout, rule, ImpactRule, **curves)


def _draw_curve(rule: Any, curve: str, layout: UILayout) -> None:
    column = layout.column(align=True)
    column.prop(rule, curve, index=0)
    column.prop(rule, curve, index=1, text="at Full Energy")


class HAPTIC_PT_textures(ScenePanel):
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


class HAPTIC_PT_contacts(ScenePanel):
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
            draw_parameters(layout, rule, on_contact=True)


class HAPTIC_PT_overlay(ScenePanel):
    bl_label = "Overlay"
    bl_translation_context = (
        "Haptics"  # Blender's translation of the word is that of mixing colours
    )

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.haptics, "show_overlay", text="")

    def draw(self, context: Context) -> None:
        layout = settings_layout(self)
        haptics = context.scene.haptics
        column = layout.column(align=True)
        column.active = haptics.show_overlay
        draw_each(
            column, haptics, "show_intra", "show_best_paths", "show_labels", "show_flow", "xray"
        )
        draw_properties(layout, haptics.meters, "show", "show_body", "corner")
