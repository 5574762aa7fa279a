"""Operator that converts a sound to vibration."""

from __future__ import annotations

import bpy
from bpy.types import Context, Operator

from ..blender import job
from ..blender.polling import Edit, poll_active
from ..io import sound_source

_rpt = bpy.app.translations.pgettext_rpt


class HAPTIC_OT_convert_sound(Edit, Operator):
    """Make vibration of the sound; it is kept with this file, so convert again after changing the sound or these settings"""

    bl_label = "Convert Sound"

    poll = classmethod(poll_active)

    def apply(self, context: Context) -> set[str]:
        try:
            work = sound_source.Conversion(context.scene, context.object)
        except (OSError, ValueError) as error:
            context.object.haptics.source.sound.fault = str(error)
            raise
        written = [({"INFO"}, _rpt("Sound converted"))]
        return job.run(self, context, job.Job("Converting", work.step_count, work.steps(), lambda running: written, "Convert Sound"))
