"""The menu of materials, and the panel of the scene's library."""

from __future__ import annotations

from typing import Any

from bpy.types import Context, Menu, UILayout, UIList

from ...core.scene.coefficients import transfer_coefficient
from ...core.scene.library import LibraryMaterial
from ...core.scene.materials import MATERIALS
from .drawing import ScenePanel, draw_held
from .thumbnails import cell

_WITH_OBJECTS = ("kappa", "rho", "wave_speed")
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
        matching = layout.operator(
            "haptic.guess_material", text="Match Materials", icon="LINENUMBERS_ON"
        )
        matching.match = True
        layout.operator("haptic.new_material", icon="ADD")
        layout.separator()
        titles = {material.title for material in MATERIALS.values()}
        for item in context.scene.haptics.materials.items:
            if item.name not in titles:
                own = layout.operator(
                    "haptic.apply_material", text=item.name, icon="MATERIAL", translate=False
                )
                own.name, own.target = item.name, target
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
    layout.label(text="Model")
    row = layout.row(align=True)
    row.operator("haptic.set_model", text="Physical").model = "PHYSICAL"
    row.operator("haptic.set_model", text="As in the Paper").model = "PAPER"
