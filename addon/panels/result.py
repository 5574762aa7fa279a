"""Panel "Result": what each listener feels in the traced frame, and what tracing it took."""

from __future__ import annotations

import math

from bpy.types import Context, Panel, UILayout

from ...core.frame_result import FrameResult
from .. import session
from .drawing import HapticsPanel, draw_pair

_SHOWN_SOURCES = 4


class HAPTIC_PT_result(HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_result"
    bl_label = "Result"
    bl_order = 40

    def draw(self, context: Context) -> None:
        layout = self.layout
        result = session.result_of(context.scene)
        if result is None:
            layout.label(text="Nothing traced yet: play, or", icon="INFO")
            layout.operator("haptic.trace_frame", icon="FILE_REFRESH")
            return
        row = layout.row()
        row.label(text=f"Frame {result.number}")
        row.operator("haptic.trace_frame", text="", icon="FILE_REFRESH")
        for index, listener in enumerate(result.listeners):
            _draw_listener(layout, result, index, listener.name)
        if not result.listeners:
            layout.label(text="No listener: add one to feel something", icon="INFO")


class HAPTIC_PT_statistics(HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_statistics"
    bl_parent_id = "HAPTIC_PT_result"
    bl_label = "Statistics"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        layout = self.layout
        result = session.result_of(context.scene)
        if result is None:
            layout.label(text="Nothing traced yet")
            return
        column = layout.column(align=True)
        for stage, milliseconds in result.milliseconds.items():
            draw_pair(column, stage.replace("_", " ").title(), f"{milliseconds:.2f} ms")
        column.separator()
        for name, value in result.statistics.items():
            draw_pair(column, name.replace("_", " ").capitalize(), f"{value:g}")


def _draw_listener(layout: UILayout, result: FrameResult, index: int, name: str) -> None:
    """A listener's peak as a bar, and the strongest sources that reach it."""
    box = layout.box()
    row = box.row()
    row.operator("haptic.select_object", text=name, icon="OUTLINER_OB_LIGHTPROBE", emboss=False).name = name
    peak = result.peak(index)
    row.progress(factor=min(peak, 1.0), text=f"{peak:.2f}")
    gains = sorted(((float(result.gains[s, index]), source.name) for s, source in enumerate(result.sources)), key=lambda g: (-g[0], g[1]))
    felt = [(gain, source) for gain, source in gains if gain > 0]
    column = box.column(align=True)
    column.scale_y = 0.8
    for gain, source in felt[:_SHOWN_SOURCES]:
        draw_pair(column, source, f"{gain:.3f}  {20 * math.log10(gain):.0f} dB")
    if len(felt) > _SHOWN_SOURCES:
        column.label(text=f"and {len(felt) - _SHOWN_SOURCES} more")
    if not felt:
        column.label(text="Nothing reaches it")


CLASSES = (HAPTIC_PT_result, HAPTIC_PT_statistics)
