"""Panel "In VR": the session, and hands in it."""

from __future__ import annotations

import bpy
from bpy.types import Context, Panel

from ..gateway import is_loaded
from ..live_output import outputs
from ..vr import actions, controllers
from .drawing import ScenePanel


class HAPTIC_PT_vr(ScenePanel, Panel):
    bl_label = "In VR"

    @classmethod
    def poll(cls, context: Context) -> bool:
        """This Blender has VR sessions."""
        return bool(getattr(bpy.app.build_options, "xr_openxr", False))

    def draw(self, context: Context) -> None:
        layout, runs = self.layout, actions.is_running()
        layout.operator(
            "wm.xr_session_toggle",
            text="Stop VR Session" if runs else "Start VR Session",
            icon="VIEW_CAMERA",
            depress=runs,
        )
        column = layout.column(align=True)
        used = is_loaded(controllers) and controllers.hands() is not None
        column.operator("haptic.vr_hands", icon="VIEW_PAN", depress=used)
        records = is_loaded(controllers) and controllers.is_recording()
        column.operator("haptic.record_hands", icon="REC", depress=records)
        if runs and outputs.found(controllers.KEY) is None:
            layout.label(text="Start the session again to feel it", icon="INFO")
