"""Panel "What Is Felt": margins of listeners and sources, solo and mute; and, in Properties >
Scene, a comparison of the modes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy
from bpy.types import Context, Panel, UILayout

from ...core.scene.choices import SourceKind
from ...core.scene.values import MODES
from ..bake import playback
from ..blender.words import show, show_pair, ui_text
from ..session import sessions
from ..view import (
    comparison,
    levels,
    table,
    watched,
)
from .drawing import ScenePanel, SidebarPanel, draw_more, select_button
from .texts import fitted, shortened_to

if TYPE_CHECKING:
    from ...core.arrays import FloatArray
    from ...core.render.frame_result import FrameResult

_LISTENERS = 10
_SOURCES = 4
_ROWS = 40
_NAMES = 0.62  # of the width beside switches


class HAPTIC_PT_result(SidebarPanel):
    bl_label = "What Is Felt"
    bl_order = 20

    @classmethod
    def poll(cls, context: Context) -> bool:
        return bool(watched.levels_of(context.scene))

    def draw(self, context: Context) -> None:
        layout = self.layout
        scene = context.scene
        row = layout.row(align=True)
        row.prop(scene.haptics.meters, "show", toggle=True)
        row.popover("HAPTIC_PT_table", text="", icon="SPREADSHEET")
        column = layout.column(align=True)
        if not scene.haptics.meters.show:
            shown = watched.levels_of(scene)
            for level in shown[:_LISTENERS]:
                _draw_level(column, level)
            draw_more(column, len(shown) - _LISTENERS)
        traced = sessions.shown(scene)
        if traced is not None:
            _draw_sources(layout.column(align=True), context, traced.result)


def _draw_level(layout: UILayout, level: levels.Level) -> None:
    """Draw a listener's name, which selects it, its margin as a bar, pale unless it is felt, and
    its switches."""
    row = layout.row(align=True)
    split = _draw_name(row, level.listener, "OUTLINER_OB_LIGHTPROBE", level.title)
    split.active = level.is_felt
    split.progress(factor=level.place, text=level.margin_text())
    _draw_switches(row, level.listener, "listener")


def _draw_name(layout: UILayout, name: str, icon: str, title: str) -> UILayout:
    """Draw a title beside switches, which selects the object of that name. Returns the place to
    the right."""
    split = layout.split(factor=_NAMES, align=True)
    row = split.row()
    row.alignment = "LEFT"
    select_button(row, name, fitted(title, 0.55, icon=True, button=True), icon=icon, emboss=False)
    return split.row(align=True)


def _draw_switches(layout: UILayout, name: str, role: str) -> None:
    """Draw solo and mute of a source or listener if it is an object of this file."""
    obj = bpy.data.objects.get(name)
    if obj is not None and getattr(obj.haptics, role).enabled:
        owner = getattr(obj.haptics, role)
        solo = "SOLO_ON" if owner.solo else "SOLO_OFF"
        mute = "MUTE_IPO_OFF" if owner.muted else "MUTE_IPO_ON"
        layout.prop(owner, "solo", text="", icon=solo, emboss=False)
        layout.prop(owner, "muted", text="", icon=mute, emboss=False)


def _draw_sources(layout: UILayout, context: Context, result: FrameResult) -> None:
    """Draw by how much the watched listener feels each source, in the order of their names, the
    strongest if there are many."""
    latest = watched.felt_at_watched(context.scene)
    heard = None if latest is None else latest.value
    felt = {} if heard is None else {item.source.name: item for item in heard.sources}
    lasting = [source.name for source in result.sources if source.kind is SourceKind.PERSISTENT]
    strongest = sorted(lasting, key=lambda name: -felt[name].margin if name in felt else math.inf)
    for name in sorted(strongest[:_SOURCES]):
        item = felt.get(name)
        row = layout.row(align=True)
        cell = _draw_name(row, name, "OUTLINER_OB_FORCE_FIELD", name)
        cell.active = item is not None and item.state == "felt"
        words = levels.margin_words(item.margin) if item is not None else "\N{EM DASH}"
        if item is not None and item.masker:
            words = ui_text("not felt")
        show(cell, fitted(words, 0.35))
        _draw_switches(row, name, "source")
    draw_more(layout, len(lasting) - _SOURCES)


class HAPTIC_PT_table(Panel):
    """Every source at every listener that it reaches, as a table that can be sorted and copied"""

    bl_label = "Result"
    bl_space_type = "VIEW_3D"
    bl_region_type = "HEADER"
    bl_options = {"INSTANCED"}
    bl_ui_units_x = 26

    def draw(self, context: Context) -> None:
        layout, scene = self.layout, context.scene
        layout.row().prop(scene.haptics.meters, "sort_table", expand=True)
        found = table.rows(scene)
        grid = layout.grid_flow(row_major=True, columns=5, even_columns=True, align=True)
        for row in found[:_ROWS]:
            for text in table.cells(row):
                show(grid, shortened_to(text, 84.0))
        draw_more(layout, len(found) - _ROWS)


class HAPTIC_PT_comparison(ScenePanel):
    bl_label = "Compare Modes"

    def draw(self, context: Context) -> None:
        layout = self.layout
        scene = context.scene
        traced = sessions.shown(scene)
        if traced is None or not traced.result.listeners:
            layout.label(
                text="Nothing traced yet"
                if traced is None
                else "No listener: add one to feel something"
            )
            return
        result = traced.result
        if playback.is_from_track(result):
            layout.label(text="This frame was not traced:", icon="INFO")
            layout.label(text="switch off Play Baked Track", icon="BLANK1")
            return
        amplitudes = comparison.compared(scene)
        layout.label(text="Amplitude of the strongest source in dB")
        column = layout.column(align=True)
        for mode, (title, _) in MODES.items():
            name = f"{ui_text(title)} ({mode})"
            column.prop_enum(scene.haptics, "mode", mode.value, text=name, translate=False)
            for index, listener in enumerate(result.listeners):
                text = (
                    _amplitude_text(amplitudes[mode].value, index) if mode in amplitudes else "..."
                )
                show_pair(column, fitted(listener.name, 0.7), text, 0.7)
        if len(amplitudes) < len(MODES) or not all(
            latest.is_current for latest in amplitudes.values()
        ):
            layout.label(text="Comparing...", icon="SORTTIME")


def _amplitude_text(amplitudes: FloatArray, index: int) -> str:
    """The amplitude that arrives at a listener in whole decibels; a dash if nothing does, or if it
    is not in the frame."""
    amplitude = float(amplitudes[index]) if index < len(amplitudes) else 0.0
    return f"{20 * math.log10(amplitude):.0f}" if amplitude > 0 else "\N{EM DASH}"
