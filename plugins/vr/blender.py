"""Virtual-reality sessions: their start, hands in them with operators and a panel, and the hands in
the viewport."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.app.handlers import persistent
from bpy.types import Context, SpaceView3D

from ...addon.blender.compatibility import THREADS_ENDANGER_SCRIPTS
from ...addon.blender.handlers import Handlers
from ...addon.blender.polling import UNDO, Action, Need, Refused
from ...addon.gateway import StandIn, is_loaded
from ...addon.panels.drawing import ScenePanel, warn
from . import actions

outputs = StandIn(f"{__package__.rpartition('.plugins.')[0]}.addon.live_output.outputs")
controllers = StandIn(f"{__package__}.controllers")
recording = StandIn(f"{__package__}.recording")
drawing = StandIn(f"{__package__}.drawing")
SESSION = Need(lambda context: actions.is_running(), "Start a VR session first")


class HAPTIC_OT_vr_hands(Action):
    """Follow the VR controllers with two hands: the controllers play what these touch, instead of what the scene's listeners feel"""

    bl_label = "VR Hands"
    needs = (SESSION,)

    def apply(self, context: Context) -> None:
        if THREADS_ENDANGER_SCRIPTS:
            raise Refused("VR Hands need Blender 5.1 or newer")
        wanted = controllers.hands() is None
        if wanted and outputs.found(controllers.KEY) is None:
            raise Refused("The session has no controllers of this add-on: start it again")
        controllers.use_hands(wanted)
        if wanted and controllers.KEY not in outputs.running():
            bpy.ops.haptic.connect_device(device=controllers.KEY)


class HAPTIC_OT_record_hands(Action):
    """Record the hands while the timeline plays; a second click adds them as objects with keyframes"""

    bl_label = "Record Hands"
    bl_options = UNDO
    needs = (SESSION,)

    def apply(self, context: Context) -> None:
        if controllers.hands() is None:
            raise Refused("Switch VR Hands on first")
        begins = not controllers.is_recording()
        take = controllers.record(begins)
        if begins:
            return
        if not take:
            raise Refused("Nothing was recorded: play the timeline while recording")
        recording.add(context.scene, take)


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


CLASSES = (HAPTIC_OT_vr_hands, HAPTIC_OT_record_hands, HAPTIC_PT_vr)


@persistent
def session_begins(*_: Any) -> None:
    """Come again after the handlers of all add-ons, of which one may activate its own actions."""
    bpy.app.handlers.xr_session_start_pre.append(_actions_exist)


@persistent
def _actions_exist(*_: Any) -> None:
    bpy.app.handlers.xr_session_start_pre.remove(_actions_exist)
    action_set = actions.create()
    if action_set:
        controllers.begin(action_set)


def _draw_hands() -> None:
    if is_loaded(controllers):
        drawing.draw()


_HANDLERS = Handlers(xr_session_start_pre=session_begins)
_drawing: list[Any] = []


def register() -> None:
    _HANDLERS.add()
    _drawing.append(SpaceView3D.draw_handler_add(_draw_hands, (), "WINDOW", "POST_VIEW"))


def unregister() -> None:
    """Stop the controllers at once."""
    while _drawing:
        SpaceView3D.draw_handler_remove(_drawing.pop(), "WINDOW")
    _HANDLERS.remove()
    if is_loaded(controllers):
        controllers.end()
