"""Operators on the signals of sources: draw them, hear them, take them from the library and keep them there."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import FloatProperty, IntProperty, StringProperty
from bpy.types import Context, Event, Operator

from ..blender.polling import UNDO, poll_active
from ..io import drawings, signal_library
from ..live_output import preview
from ..scene_reader import imported

_rpt = bpy.app.translations.pgettext_rpt


def _poll_drawing(cls: type[Operator], context: Context) -> bool:
    """An active object that can be edited, with a drawn signal that can be edited."""
    if not poll_active(cls, context):
        return False
    tree = context.object.haptics.source.drawing
    if tree is None or not tree.is_editable:
        cls.poll_message_set("Draw a signal of this file first")
        return False
    return True


class HAPTIC_OT_draw_signal(Operator):
    """Draw the signal of the active source as curves: a new drawn signal that begins with what it emits now"""

    bl_idname = "haptic.draw_signal"
    bl_label = "New"
    bl_options = UNDO

    poll = classmethod(poll_active)

    def execute(self, context: Context) -> set[str]:
        obj = context.object
        source = obj.haptics.source
        source.drawing = drawings.drawn_like(obj, context.scene)
        source.signal = "DRAWN"
        return {"FINISHED"}


class HAPTIC_OT_shape_envelope(Operator):
    """Draw an envelope that rises, falls to a level, stays there and ends"""

    bl_idname = "haptic.shape_envelope"
    bl_label = "Shape Envelope"
    bl_options = UNDO

    attack: FloatProperty(name="Attack (s)", description="Time of the rise to full amplitude", default=0.05, min=0.0, max=100.0)
    decay: FloatProperty(name="Decay (s)", description="Time of the fall to the level that is held", default=0.15, min=0.0, max=100.0)
    sustain: FloatProperty(name="Sustain", description="The level that is held", default=0.6, min=0.0, max=1.0, subtype="FACTOR")
    release: FloatProperty(name="Release (s)", description="Time of the fall to silence at the end", default=0.3, min=0.0, max=100.0)

    poll = classmethod(_poll_drawing)

    def execute(self, context: Context) -> set[str]:
        tree = context.object.haptics.source.drawing
        drawings.shape_envelope(tree, self.attack, self.decay, self.sustain, self.release)
        return {"FINISHED"}


class HAPTIC_OT_switch_envelopes(Operator):
    """Edit the drawn signal as F-curves in the Graph Editor, or make these its curves again"""

    bl_idname = "haptic.switch_envelopes"
    bl_label = "To F-Curves"
    bl_options = UNDO

    poll = classmethod(_poll_drawing)

    def execute(self, context: Context) -> set[str]:
        obj = context.object
        switch = drawings.from_fcurves if drawings.has_fcurves(obj) else drawings.to_fcurves
        try:
            switch(obj, context.scene)
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class HAPTIC_OT_edit_emphasis(Operator):
    """Add an emphasis, a short burst like a click, or remove it"""

    bl_idname = "haptic.edit_emphasis"
    bl_label = "Add Emphasis"
    bl_options = UNDO

    index: IntProperty(name="Number", description="Which one is removed; -1 adds one", default=-1, options={"HIDDEN"})

    poll = classmethod(_poll_drawing)

    def execute(self, context: Context) -> set[str]:
        emphases = context.object.haptics.source.drawing.haptics.emphases
        if self.index >= 0:
            emphases.remove(self.index)
        else:
            last = emphases[-1].place if emphases else 0.4
            emphases.add().place = last + 0.1
        return {"FINISHED"}


class HAPTIC_OT_hear_signal(Operator):
    """Hear a signal through the speaker"""

    bl_idname = "haptic.hear_signal"
    bl_label = "Hear"
    bl_options = {"INTERNAL"}

    filepath: StringProperty(name="File", description="The signal of the library; that of the active source where empty")

    def execute(self, context: Context) -> set[str]:
        try:
            preview.hear(signal_library.read(Path(self.filepath)) if self.filepath else drawings.signal_of(context.object, context.scene))
        except (preview.AudioUnavailable, ValueError, OSError) as error:
            self.report({"WARNING"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class HAPTIC_OT_use_signal(Operator):
    """Let the active source emit this signal of the library"""

    bl_idname = "haptic.use_signal"
    bl_label = "Use Signal"
    bl_options = UNDO

    filepath: StringProperty(name="File", description="The signal of the library", options={"HIDDEN"})

    poll = classmethod(poll_active)

    def execute(self, context: Context) -> set[str]:
        source = context.object.haptics.source
        try:
            signal = signal_library.read(Path(self.filepath))
            tree = drawings.drawn(Path(self.filepath).stem, signal)
        except (ValueError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if tree is None:
            source.imported = imported.text_of(signal=signal.to_dict())
        source.drawing = tree or source.drawing
        source.signal = "DRAWN" if tree else "KEPT"
        return {"FINISHED"}


class HAPTIC_OT_save_signal(Operator):
    """Keep the signal of the active source in the library, for all files"""

    bl_idname = "haptic.save_signal"
    bl_label = "Save to Library"

    name: StringProperty(name="Name", description="Name in the library; one of that name is replaced")

    poll = classmethod(poll_active)

    def invoke(self, context: Context, event: Event) -> set[str]:
        source = context.object.haptics.source
        self.name = source.drawing.name if source.signal == "DRAWN" and source.drawing else context.object.name
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context: Context) -> set[str]:
        try:
            path = signal_library.save(self.name, drawings.signal_of(context.object, context.scene))
        except (ValueError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, _rpt("Saved: {}").format(path))
        return {"FINISHED"}
