"""Panel "Sound": the conversion of a sound to the signal of a source."""

from __future__ import annotations

from bpy.types import Context

from ..blender import compatibility
from ..io import sound_source
from ..properties.preferences import preferences
from ..properties.sound import SHOWN
from ..view import panel_picture, sound_picture
from .drawing import ObjectPanel, draw_properties, settings_layout
from .texts import draw_sentence


class HAPTIC_PT_sound(ObjectPanel):
    bl_parent_id = "HAPTIC_PT_source"
    bl_label = "Sound to Vibration"

    @classmethod
    def poll(cls, context: Context) -> bool:
        obj = context.object
        return (
            obj is not None and obj.haptics.source.enabled and obj.haptics.source.signal == "SOUND"
        )

    def draw(self, context: Context) -> None:
        layout = settings_layout(self)
        sound = context.object.haptics.source.sound
        layout.prop(sound, "origin")
        if sound.origin == "FILE":
            layout.prop(sound, "filepath")
            layout.prop(sound, "loop")
        elif sound.origin == "SPEAKER":
            layout.prop(sound, "speaker")
        elif context.scene.sequence_editor is not None:
            layout.prop_search(sound, "strip", context.scene.sequence_editor, compatibility.STRIPS)
        if sound.fault:
            draw_sentence(layout, sound.fault, "ERROR")
        draw_properties(layout, sound, "carrier", *SHOWN[sound.carrier], "gain")
        layout.operator("haptic.convert_sound", icon="FILE_REFRESH")
        if sound.kept:
            now = sound_source.taken(context.scene, sound)
            if sound.is_edited or sound.taken != now:
                draw_sentence(layout, "Changed since it was converted", "INFO")
            colour = tuple(preferences().curve_colour)
            ink = panel_picture.theme_ink(context)
            layout.template_icon(icon_value=sound_picture.icon(sound.waves, colour, ink), scale=7.0)
            layout.label(text="The vibration, and over it the sound")
