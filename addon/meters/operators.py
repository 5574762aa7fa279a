"""Operators: one click from one rendering to the other."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import EnumProperty
from bpy.types import Context, Operator

from .. import session
from ..bake import playback
from ..operators.polling import UNDO
from ..overlay import draw

MODES = ("HT", "SD", "MD", "MN")
_ITEMS = (
    ("HT", "Haptic Tracing", "Through touching objects, as their properties say"),
    ("SD", "Single Nearest", "Only the listener nearest to each source, fading with distance alone"),
    ("MD", "All by Distance", "Every source directly to every listener, fading with distance alone"),
    ("MN", "All Alike", "Every source directly to every listener, without fading"),
    ("NEXT", "Next", "The one after the current: HT, SD, MD, MN, HT"),
)


class HAPTIC_OT_set_mode(Operator):
    """Render the scene in another way, to compare: through touching objects, at the nearest listener, by distance, or without fading"""

    bl_idname = "haptic.set_mode"
    bl_label = "Set Haptic Mode"
    bl_options = UNDO

    mode: EnumProperty(name="Mode", description="The rendering", items=_ITEMS, default="NEXT")

    @classmethod
    def description(cls, context: Context, properties: Any) -> str:
        """The tooltip of a button: what its mode does."""
        return next(f"{title}: {words}" for name, title, words in _ITEMS if name == properties.mode)

    def execute(self, context: Context) -> set[str]:
        haptics = context.scene.haptics
        if playback.plays(context.scene):
            haptics.bake.use_track = False
            self.report({"INFO"}, "Play Baked Track is off now: another mode has to be traced")
        following = MODES[(MODES.index(haptics.mode) + 1) % len(MODES)]
        haptics.mode = following if self.mode == "NEXT" else self.mode
        session.trace(context.scene, context.evaluated_depsgraph_get())
        draw.redraw()
        return {"FINISHED"}


CLASSES = (HAPTIC_OT_set_mode,)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
