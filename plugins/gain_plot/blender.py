"""Panel of the gain over distance."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bpy.types import Context

from ...addon.blender.words import show, show_pair
from ...addon.gateway import StandIn
from ...addon.panels.drawing import ObjectPanel
from ...addon.properties.preferences import gain_text, preferences
from ...addon.scene_reader import functions
from ...addon.view import panel_picture
from ...core.declaration import default_of
from ...core.scene.coefficients import transfer_coefficient
from ...core.scene.values import Settings

if TYPE_CHECKING:
    from ...core.scene.functions import ModulationFunction

gain_plot = StandIn(f"{__package__}.gain_plot")


class HAPTIC_PT_gain(ObjectPanel):
    bl_parent_id = "HAPTIC_PT_object"
    bl_label = "Gain over Distance"
    bl_options: Any = set()

    @classmethod
    def poll(cls, context: Context) -> bool:
        obj = context.object
        return obj is not None and obj.type != "ARMATURE" and obj.haptics.enabled

    def draw(self, context: Context) -> None:
        layout = self.layout
        haptics = context.object.haptics
        key = _curve_key(haptics)
        latest = None if key is None else gain_plot.latest_curve(key)
        if key is not None and latest is None:
            layout.label(text="Computing...", icon="SORTTIME")
            return
        curve = None if latest is None else latest.value
        if curve is None:
            layout.label(text="The formula gives no gain", icon="ERROR")
            return
        icon = gain_plot.icon(
            curve, tuple(preferences().curve_colour), panel_picture.theme_ink(context)
        )
        layout.template_icon(icon_value=icon, scale=7.0)
        row = layout.row()
        show(row, f"0 {curve.unit}, 0 \N{HORIZONTAL ELLIPSIS} \N{MINUS SIGN}60 dB")
        side = row.row()
        side.alignment = "RIGHT"
        side.label(text=f"{curve.length:g} {curve.unit}")
        column = layout.column(align=True)
        column.scale_y = 0.8
        if haptics.function == "haptic_tracing":
            show_pair(
                column, "K = (1 - κ) ρ", f"{transfer_coefficient(haptics.kappa, haptics.rho):.2f}"
            )
        for distance in (0.0, curve.length / 10, curve.length / 2):
            show_pair(column, f"{distance:g} {curve.unit}", gain_text(curve.at(distance)))
        if curve.bands is not None:
            is_spring = haptics.function == "resilient"
            column.label(
                text="Thin lines: 1, 10 and 100 kg"
                if is_spring
                else "Thin lines: 30, 100 and 300 Hz"
            )


def _curve_key(
    haptics: Any,
) -> tuple[ModulationFunction, float, float, float] | None:
    """The values that determine the active object's curve; None if its function is invalid."""
    try:
        epsilon = default_of(Settings, "epsilon")
        return functions.read_function(haptics), haptics.kappa, haptics.rho, epsilon
    except ValueError:
        return None


CLASSES = (HAPTIC_PT_gain,)


def register() -> None:
    """Register nothing else: Blender needs the class alone."""


def unregister() -> None:
    """Unregister nothing else."""
