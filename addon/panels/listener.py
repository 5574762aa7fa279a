"""Panel "Haptic Listener": what the active object feels."""

from __future__ import annotations

from functools import partial

from bpy.types import Context, UILayout

from ...core.render import mixing
from ...core.scene.values import Listener
from ..properties.listener import HapticListenerProperties
from .drawing import ObjectPanel, draw_carrier, draw_held, poll_object, settings_layout
from .formula import draw_finding


class HAPTIC_PT_listener(ObjectPanel):
    bl_label = "Haptic Listener"

    poll = classmethod(poll_object)

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.object.haptics.listener, "enabled", text="")

    def draw(self, context: Context) -> None:
        layout = settings_layout(self, is_animated=True)
        listener = context.object.haptics.listener
        if not listener.enabled:
            return
        draw_held(
            layout,
            listener,
            Listener,
            mixing_expression=partial(_draw_formula, listener),
            full_scale=partial(_draw_full_scale, listener),
            full_scale_unit=None,
            full_scale_source=None,
        )
        layout.prop(listener, "muted")
        draw_carrier(layout, context.object, "Feels")
        layout.operator(
            "haptic.add_default_listeners", text="Add Body Listeners", icon="OUTLINER_OB_ARMATURE"
        )


def _draw_full_scale(listener: HapticListenerProperties, layout: UILayout) -> None:
    """Draw the calibration of the device; margins of listeners without one are assumed."""
    row = layout.row(align=True)
    row.prop(listener, "full_scale")
    row.operator("haptic.calibrate_listener", text="", icon="PRESET")
    if listener.full_scale:
        layout.prop(listener, "full_scale_unit")
        layout.prop(listener, "full_scale_source")
    else:
        layout.label(text="Not calibrated: its margins are assumed", icon="INFO")


def _draw_formula(listener: HapticListenerProperties, layout: UILayout) -> None:
    """Draw the formula of custom mixing with its fault."""
    if listener.mixing == "custom":
        row = layout.row()
        row.use_property_split = False
        row.prop(listener, "mixing_expression", text="")
        draw_finding(
            layout,
            listener.mixing_expression,
            mixing.check_mixing(listener.mixing_expression, listener.s_max),
        )
