"""File > Import: vibrations and sounds as signals of sources."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy.props import StringProperty
from bpy.types import Context, Event

from ...core.formats import registry
from ...core.formats.io.catalogue import readers
from ..blender.polling import Edit, OnActive, Refused
from ..io import vibration_signal
from ..properties.kinds import switch, text, whole
from ..properties.sound import SOUNDS, sound_path
from ..scene_reader import kept_signal
from .exporting import MOST_REPORTED
from .signals import convert_sound
from .tagging import let_shake


class _FromFile:
    """Mixin: an import of a file that is chosen in the file browser, or dropped, after which there are only the options."""

    filepath: StringProperty(name="File Path", subtype="FILE_PATH", options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self: Any, context: Context, event: Event) -> set[str]:
        manager = context.window_manager
        if self.properties.is_property_set("filepath"):
            return manager.invoke_props_dialog(
                self, title=Path(self.filepath).name, confirm_text=self.bl_label
            )
        manager.fileselect_add(self)
        return {"RUNNING_MODAL"}


class HAPTIC_OT_drop_scene(Edit):
    """Say where a haptic scene is opened"""

    bl_label = "Haptic Scene"
    bl_options = {"INTERNAL"}

    filepath: text("File", "The file that was dropped", options={"HIDDEN", "SKIP_SAVE"})

    def apply(self, context: Context) -> None:
        raise Refused(
            "{} was exported from a .blend: open that here; outside Blender, haptic_tracing.load "
            "opens the haptic scene",
            Path(self.filepath).name,
        )


class HAPTIC_OT_import_signal(_FromFile, OnActive):
    """Let the active object emit the vibration in a file; it is kept with this file"""

    bl_label = "Import Haptic Signal"

    channel: whole("Channel", "Which one of the file's vibrations", 1, (1, 2**31 - 1), soft_max=32)
    loop: switch("Loop", "Play it again and again; otherwise once, at the scene's beginning", True)

    @classmethod
    def complete(cls) -> None:
        """Before its registration: which files are shown follows from the formats that there are."""
        shown = ";".join(f"*{suffix}" for suffix in readers())
        cls.__annotations__["filter_glob"] = StringProperty(default=shown, options={"HIDDEN"})

    def apply(self, context: Context) -> None:
        obj = context.object
        reading = registry.read(bpy.path.abspath(self.filepath))
        channel = vibration_signal.chosen_channel(reading, self.channel)
        signal = vibration_signal.signal_of(channel, self.loop)
        let_shake(context.scene, obj)
        source = obj.haptics.source
        source.enabled = True
        source.kept = kept_signal.text_of_signal(signal)
        source.signal = "KEPT"
        for loss in reading.losses[:MOST_REPORTED]:
            self.warn(loss)
        self.tell(
            "'{}' emits {}" if len(reading.channels) == 1 else "'{}' emits {}, channel {} of {}",
            obj.name,
            channel.name,
            self.channel,
            len(reading.channels),
        )


class HAPTIC_OT_import_sound(_FromFile, OnActive):
    """Let the active object emit the vibration of a sound, which Sound to Vibration converts; it is kept with this file"""

    bl_label = "From Sound..."

    filter_glob: StringProperty(
        default=";".join(f"*{suffix}" for suffix in SOUNDS), options={"HIDDEN"}
    )
    loop: switch("Loop", "Play it again and again; otherwise once, at the scene's beginning")

    def apply(self, context: Context) -> set[str]:
        source = context.object.haptics.source
        sound_path(context.object, self.filepath)
        let_shake(context.scene, context.object)
        source.enabled = True
        source.signal, source.sound.origin = "SOUND", "FILE"
        source.sound.filepath, source.sound.loop = self.filepath, self.loop
        return convert_sound(self, context, context.object)
