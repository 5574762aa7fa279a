"""The menu of materials, and the panel of the scene's library."""

from __future__ import annotations

from typing import Any

from bpy.types import Context, Menu, UILayout, UIList

from ...core.scene.bands import BAND_CENTRES
from ...core.scene.coefficients import transfer_coefficient
from ...core.scene.library import LibraryMaterial
from ...core.scene.materials import MATERIALS
from ..blender import job
from ..blender.words import show, show_pair, ui_text
from ..view import levels, watched
from .drawing import ScenePanel, draw_each, draw_held, settings_layout
from .texts import draw_sentence, fitted
from .thumbnails import cell

_WITH_OBJECTS = (
    "kappa",
    "rho",
    "use_delay",
    "wave_speed",
    "use_bands",
    "band_decays",
    "conductivity",
)
"""Values of a material that the panels of its objects show."""


class HAPTIC_UL_materials(UIList):
    """The haptic materials of the scene, each with its coefficient (1 - κ) ρ."""

    def draw_item(  # type: ignore[override]  # the filter flags, which Blender passes last, may be left out
        self,
        context: Context,
        layout: UILayout,
        data: Any,
        item: Any,
        icon: int,
        active_data: Any,
        active_property: str,
        index: int = 0,
    ) -> None:
        row = layout.row(align=True)
        row.prop(item, "name", text="", emboss=False, icon="MATERIAL")
        side = row.row()
        side.alignment = "RIGHT"
        side.label(text=f"{transfer_coefficient(item.kappa, item.rho):.2f}")


class HAPTIC_MT_materials(Menu):
    bl_label = "Materials"

    def draw(self, context: Context) -> None:
        layout = self.layout
        target = context.scene.haptics.materials.target
        layout.operator("haptic.guess_material", icon="VIEWZOOM")
        layout.operator("haptic.match_materials", icon="LINENUMBERS_ON")
        layout.operator("haptic.new_material", icon="ADD")
        layout.separator()
        flow = layout.column_flow(columns=7)
        for name, material in MATERIALS.items():
            properties = cell(flow, f"material-{name}").operator(
                "haptic.apply_material", text=material.title
            )
            properties.preset, properties.target = name, target


class HAPTIC_PT_materials(ScenePanel):
    bl_label = "Materials"

    def draw(self, context: Context) -> None:
        layout = self.layout
        materials = context.scene.haptics.materials
        row = layout.row()
        row.template_list(
            "HAPTIC_UL_materials", "", materials, "items", materials, "active", rows=3
        )
        side = row.column(align=True)
        side.menu("HAPTIC_MT_materials", text="", icon="ADD")
        side.operator("haptic.remove_material", text="", icon="REMOVE")
        side.operator("haptic.copy_material", text="", icon="DUPLICATE")
        layout.row().prop(materials, "target", expand=True)
        if 0 <= materials.active < len(materials.items):
            item = materials.items[materials.active]
            properties = layout.operator("haptic.apply_material", text="Apply", icon="CHECKMARK")
            properties.name, properties.target = item.name, materials.target
            draw_held(layout, item, LibraryMaterial, **dict.fromkeys(_WITH_OBJECTS))
        else:
            layout.label(text="Add materials with +", icon="INFO")
        column = layout.column(align=True)
        draw_models(column)
        bodies = column.split(factor=0.22, align=True)
        bodies.label(text="Bodies")
        bodies.operator("haptic.set_bodies", text="Measured").body = "MEASURED"
        bodies.operator("haptic.set_bodies", text="Felt All Over").body = "FELT_ALL_OVER"


def draw_models(layout: UILayout) -> None:
    """Draw the choice between measured materials and the paper's model."""
    row = layout.split(factor=0.22, align=True)
    row.label(text="Model")
    row.operator("haptic.set_model", text="Physical").model = "PHYSICAL"
    row.operator("haptic.set_model", text="As in the Paper").model = "PAPER"


class HAPTIC_PT_wishes(ScenePanel):
    bl_parent_id = "HAPTIC_PT_materials"
    bl_label = "Design by Wish"

    def draw(self, context: Context) -> None:
        layout = self.layout
        shown = {level.listener: level for level in watched.levels_of(context.scene)}
        column = layout.column(align=True)
        column.label(text="Wished levels" if shown else "No listener: add one to feel something")
        for name, level in shown.items():
            obj = context.scene.objects.get(name)
            if obj is not None:
                row = column.split(factor=0.42, align=True)
                row.prop(
                    obj.haptics.listener,
                    "use_wish",
                    text=fitted(name, 0.42, icon=True),
                    translate=False,
                )
                row = row.split(factor=0.55, align=True)
                side = row.row()
                side.active = obj.haptics.listener.use_wish
                side.prop(obj.haptics.listener, "wish", text="")
                show(row, levels.decibels(level.rms))
        column = layout.column(align=True)
        items = context.scene.haptics.materials.items
        column.label(text="Free materials" if items else "Add materials with +")
        for item in items:
            row = column.split(factor=0.42, align=True)
            row.prop(item, "is_free", text=fitted(item.name, 0.42, icon=True), translate=False)
            side = row.row(align=True)
            side.active = item.is_free
            side.prop(item, "least_k")
            side.prop(item, "most_k")
        layout.operator("haptic.design_by_wish", icon="SHADERFX")


class HAPTIC_PT_fit(ScenePanel):
    bl_parent_id = "HAPTIC_PT_materials"
    bl_label = "Fit Material"

    def draw(self, context: Context) -> None:
        layout = settings_layout(self)
        fit = context.scene.haptics.materials.fit
        keys = (
            "source_file",
            "source",
            "listener_file",
            "listener",
            "is_calibrated",
            "object",
            "first",
            "second",
        )
        for pair in (keys[:2], keys[2:4], keys[4:6], keys[6:]):
            column = layout.column(align=True)
            column.active = pair != keys[6:] or fit.is_calibrated
            draw_each(column, fit, *pair)
        if job.draw_running(layout):
            return
        layout.operator("haptic.fit_material", icon="FCURVE")
        if fit.fitted:
            _draw_fit(layout, fit)


def _draw_fit(layout: UILayout, fit: Any) -> None:
    """Draw the last fit: the values, the transfer by band with that of the model before and after,
    and undetermined parameters."""
    damping, damping_error, gain, gain_error, before, after = fit.values
    column = layout.column(align=True)
    show(column, fitted(fit.fitted, icon=True), "MATERIAL")
    show_pair(column, ui_text("Loss / material's own"), f"{damping:.2f} ± {damping_error:.2f}")
    if fit.is_calibrated and fit.first and fit.second:
        show_pair(column, ui_text("Gain of the contact"), f"{gain:.2f} ± {gain_error:.2f}")
    show_pair(column, ui_text("Error before"), f"{before:.1f} dB")
    show_pair(column, ui_text("Error now"), f"{after:.1f} dB")
    grid = layout.grid_flow(row_major=True, columns=5, even_columns=True, align=True)
    for title in ("Hz", "Rec. dB", "Before", "Now", "Coh."):
        show(grid, ui_text(title))
    for number, centre in enumerate(BAND_CENTRES):
        row = fit.bands[4 * number : 4 * number + 4]
        for text in (f"{centre:.0f}", *(f"{level:.1f}" for level in row[:3]), f"{row[3]:.2f}"):
            show(grid, "\N{EM DASH}" if text == "nan" else text.replace("-", "\N{MINUS SIGN}"))
    for doubt in fit.doubts.splitlines():
        draw_sentence(layout, doubt, "INFO")
