"""Panel "In VR": the session, and hands in it."""

from __future__ import annotations

import bpy
from bpy.types import Context

from ..gateway import is_loaded
from ..live_output import outputs
from ..vr import actions, controllers
from .drawing import ScenePanel, warn


class HAPTIC_PT_vr(ScenePanel):
    bl_label = "In VR"

    @classmethod
    def poll(cls, context: Context) -> bool:
        """This Blender has VR sessions."""
        return bool(getattr(bpy.app.build_options, "xr_openxr", False))

    def draw(self, context: Context) -> None:
        layout = self.layout
        runs = actions.is_running()
        layout.operator(
            "wm.xr_session_toggle",
            text="Stop VR Session" if runs else "Start VR Session",
            icon="VIEW_CAMERA",
            depress=runs,
        )
        layout.prop(context.window_manager.xr_session_settings, "show_controllers")
        column = layout.column(align=True)
        hands = controllers.hands() if is_loaded(controllers) else None
        column.operator("haptic.vr_hands", icon="VIEW_PAN", depress=hands is not None)
        records = is_loaded(controllers) and controllers.is_recording()
        column.operator("haptic.record_hands", icon="REC", depress=records)
        if hands is not None and hands.failure is not None:
            failure = f"{type(hands.failure).__name__}: {hands.failure}"
            warn(layout, "The hands feel nothing:", failure)
        if runs and outputs.found(controllers.KEY) is None:
            layout.label(text="Start the session again to feel it", icon="INFO")
