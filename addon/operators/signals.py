"""Operators that draw, convert, preview, load and save the signals of sources."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bpy.types import Context, Event, Object, Operator

from ..blender import job
from ..blender.polling import UNDO, Need, OnActive
from ..blender.words import report_text
from ..io import drawings, signal_library, sound_source
from ..live_output import preview
from ..properties.kinds import text, whole
from ..scene_reader import kept_signal


def _has_drawing(context: Context) -> bool:
    obj: Any = context.object
    tree = obj.haptics.source.drawing
    return tree is not None and tree.is_editable


class _OnDrawing(OnActive):
    """Mixin: an operator on the drawn signal of the active source."""

    needs = (*OnActive.needs, Need(_has_drawing, "Draw a signal of this file first"))


class HAPTIC_OT_draw_signal(OnActive):
    """Draw the signal of the active source as curves: a new drawn signal that begins with what it emits now"""

    bl_label = "New"

    def apply(self, context: Context) -> None:
        source = context.object.haptics.source
        source.drawing = drawings.drawn_like(context.object, context.scene)
        source.signal = "DRAWN"


class HAPTIC_OT_edit_emphasis(_OnDrawing):
    """Add an emphasis, a short burst like a click, or remove it"""

    bl_label = "Add Emphasis"

    index: whole(
        "Number", "Which one is removed; -1 adds one", -1, (-1, 10_000), options={"HIDDEN"}
    )

    def apply(self, context: Context) -> None:
        tree: Any = context.object.haptics.source.drawing
        emphases = tree.haptics.emphases
        if self.index >= 0:
            emphases.remove(self.index)
        else:
            last = emphases[-1].place if emphases else 0.4
            emphases.add().place = last + 0.1


class HAPTIC_OT_convert_sound(OnActive):
    """Make vibration of the sound; it is kept with this file, so convert again after changing the sound or these settings"""

    bl_label = "Convert Sound"
    bl_options = {"REGISTER"}  # the job pushes its undo step

    def apply(self, context: Context) -> set[str]:
        return convert_sound(self, context, context.object)


def convert_sound(operator: Operator, context: Context, obj: Object) -> set[str]:
    """Make vibration of the sound of an object for an operator, with progress."""
    try:
        work = sound_source.Conversion(context.scene, obj)
    except (OSError, ValueError) as error:
        obj.haptics.source.sound.fault = str(error)
        raise
    written = [({"INFO"}, report_text("Sound converted"))]
    steps, count = work.steps(), work.step_count
    conversion = job.Job("Converting", count, steps, lambda running: written)
    return job.run(operator, context, conversion)


class HAPTIC_OT_hear_signal(OnActive):
    """Hear a signal through the speaker"""

    bl_label = "Hear"
    bl_options = {"INTERNAL"}

    filepath: text("File", "The signal of the library; that of the active source where empty")

    def apply(self, context: Context) -> None:
        preview.hear(
            signal_library.read(Path(self.filepath))
            if self.filepath
            else drawings.signal_of(context.object, context.scene)
        )


class HAPTIC_OT_use_signal(OnActive):
    """Let the active source emit this signal of the library"""

    bl_label = "Use Signal"
    bl_options = {*UNDO, "INTERNAL"}

    filepath: text("File", "The signal of the library", options={"HIDDEN"})

    def apply(self, context: Context) -> None:
        source = context.object.haptics.source
        path = Path(self.filepath)
        signal = signal_library.read(path)
        tree = drawings.drawn(path.stem, signal)
        if tree is None:
            source.kept = kept_signal.text_of_signal(signal)
            source.signal = "KEPT"
        else:
            source.drawing, source.signal = tree, "DRAWN"


class HAPTIC_OT_save_signal(OnActive):
    """Keep the signal of the active source in the library, for all files"""

    bl_label = "Save to Library"

    name: text("Name", "Name in the library; one of that name is replaced")

    def invoke(self, context: Context, event: Event) -> set[str]:
        source = context.object.haptics.source
        self.name = (
            source.drawing.name
            if source.signal == "DRAWN" and source.drawing
            else context.object.name
        )
        return context.window_manager.invoke_props_dialog(self)

    def apply(self, context: Context) -> None:
        path = signal_library.save(self.name, drawings.signal_of(context.object, context.scene))
        self.tell("Saved: {}", path)
