"""Operators: hands in a virtual-reality session."""

from __future__ import annotations

import bpy
from bpy.types import Context

from ..blender.compatibility import THREADS_ENDANGER_SCRIPTS
from ..blender.polling import UNDO, Action, Need, Refused
from ..live_output import outputs
from ..vr import actions, controllers, recording

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
