"""Panel "Result": what each listener feels or why it feels nothing, the path to it, a comparison of
the modes, and tracing times."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy
from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Context, Header, Panel, UILayout

from ...core.scene.choices import Mode
from ..bake import playback
from ..blender.time import is_playing
from ..live_output import unfelt
from ..session import sessions
from ..translations.sentences import sentence
from ..view import (
    comparison,
    explanation,
    levels,
    meter_layout,
    meter_pictures,
    meters,
    panel_picture,
    paths,
    watched,
)
from .cures import draw_cure
from .drawing import ClosedPanel, HapticsPanel, draw_level, draw_pair, select_button
from .texts import draw_sentence, fitted, source_title

if TYPE_CHECKING:
    from ...core.arrays import FloatArray
    from ...core.render.frame_result import FrameResult

_SHOWN_SOURCES = 4
_FELT_SOURCES = 24
_PICTURE = 5.0  # lines high
_NAMES = 0.37  # of the width
_OBJECTS = 0.48  # of the width
_BESIDE_SWITCHES = 0.8  # of the width
_ALL_IN_DETAIL = 3  # number of listeners above which only the active one shows its sources


class HAPTIC_PT_result(HapticsPanel, Panel):
    bl_label = "Result"
    bl_order = 40

    def draw(self, context: Context) -> None:
        layout = self.layout
        scene = context.scene
        row = layout.row(align=True)
        for mode in Mode:
            row.operator(
                "haptic.set_mode", text=str(mode), depress=scene.haptics.mode == mode
            ).mode = str(mode)
        traced = sessions.shown(scene)
        if traced is None:
            layout.label(text="Nothing traced yet: play, or", icon="INFO")
            layout.operator("haptic.trace_frame", icon="FILE_REFRESH")
            return
        result = traced.result
        row = layout.row()
        baked = playback.is_from_track(result)
        words = iface_("Frame {}, from the baked track" if baked else "Frame {}").format(
            result.number
        )
        row.label(text=words, icon="RENDER_ANIMATION" if baked else "NONE", translate=False)
        row.operator("haptic.trace_frame", text="", icon="FILE_REFRESH")
        if sessions.is_behind(scene) and not is_playing():
            layout.label(text="Tracing...", icon="SORTTIME")
        shown = watched.levels_of(scene)
        chosen = context.object.name_full if context.object is not None else ""
        column = layout.column(align=True)
        if shown:
            draw_pair(column, "Listener", iface_("Level", "Haptics"), 0.5)
        for index, level in enumerate(shown):
            _draw_level(column, level)
            if len(shown) <= _ALL_IN_DETAIL or level.listener == chosen:
                _draw_sources(column, result, index)
        if not result.listeners:
            layout.label(text="No listener: add one to feel something", icon="INFO")


class HAPTIC_PT_silence(HapticsPanel, Panel):
    bl_parent_id = "HAPTIC_PT_result"
    bl_label = "Why Is It Silent?"

    @classmethod
    def poll(cls, context: Context) -> bool:
        obj = context.object
        return obj is not None and obj.haptics.listener.enabled

    def draw(self, context: Context) -> None:
        layout = self.layout
        scene, name = context.scene, context.object.name_full
        layout.label(text=name, icon="OUTLINER_OB_LIGHTPROBE")
        why = explanation.why_silent(scene, name)
        if not why.is_current:
            layout.label(text="Looking for reasons...", icon="SORTTIME")
        elif not why.notice and not why.reasons:
            level = next(
                (level for level in watched.levels_of(scene) if level.listener == name), None
            )
            words = (
                iface_("It feels something")
                if level is None
                else iface_("Felt: margin {}").format(level.margin_text())
            )
            layout.label(text=words, icon="CHECKMARK", translate=False)
        for text in (why.notice, unfelt.device_words(scene, name)):
            draw_sentence(layout, text)
        for reason in why.reasons:
            box = layout.box()
            draw_sentence(box, sentence(reason))
            draw_cure(box, context, reason)


class HAPTIC_PT_felt(ClosedPanel, Panel):
    bl_parent_id = "HAPTIC_PT_result"
    bl_label = "Who Is Felt"

    def draw(self, context: Context) -> None:
        layout = self.layout
        latest = watched.felt_at_watched(context.scene)
        if latest is None or latest.value is None:
            layout.label(text="Nothing traced yet")
            return
        felt, column = latest.value, layout.column(align=True)
        column.label(
            text=fitted(felt.listener, icon=True), icon="OUTLINER_OB_LIGHTPROBE", translate=False
        )
        column.label(
            text=iface_("{} felt, {} masked, {} too weak").format(*felt.counts()), translate=False
        )
        for source in felt.sources[:_FELT_SOURCES]:
            row = column.row(align=True)
            row.active = source.state == "felt"
            words = (
                iface_("by {}").format(source.masker)
                if source.masker
                else levels.margin_words(source.margin)
            )
            draw_pair(row, source_title(source.source, 0.5), fitted(words, 0.5), 0.5)
        if len(felt.sources) > _FELT_SOURCES:
            column.label(
                text=iface_("and {} more").format(len(felt.sources) - _FELT_SOURCES),
                translate=False,
            )


class HAPTIC_PT_path(HapticsPanel, Panel):
    bl_parent_id = "HAPTIC_PT_result"
    bl_label = "Path"

    def draw(self, context: Context) -> None:
        layout = self.layout
        traced = sessions.shown(context.scene)
        latest = None if traced is None else paths.path_of(context.scene)
        if traced is None or latest is None or latest.value is None:
            layout.label(
                text="Nothing reaches a listener" if latest is not None else "Nothing traced yet"
            )
            return
        path = latest.value.fall
        column = layout.column(align=True)
        column.scale_y = 0.85
        column.label(
            text=source_title(path.source), icon="OUTLINER_OB_FORCE_FIELD", translate=False
        )
        column.label(
            text=fitted(path.listener, icon=True), icon="OUTLINER_OB_LIGHTPROBE", translate=False
        )
        draw_pair(column, "Gain", levels.change_words(path.gain))
        if path.hops:
            layout.prop(context.scene.haptics.meters, "sort_path", toggle=True)
        elif playback.is_from_track(traced.result):
            layout.label(text="Stop the timeline to see the path")
            return
        else:
            layout.label(text="This mode ignores objects and paths")
        _draw_rows(
            layout, context, paths.rows(latest.value, context.scene.haptics.meters.sort_path)
        )


def _draw_rows(layout: UILayout, context: Context, rows: list[paths.Row]) -> None:
    """The table of a path: an object has a button that selects it, pressed for the active one, and
    its distance; a line precedes a sum."""
    active = context.object.name_full if context.object is not None else ""
    column = layout.column(align=True)
    for row in rows:
        if row.is_sum:
            column.separator(type="LINE")
        if row.is_object:
            name, distance, change = _columns(column)
            select_button(
                name, row.name, fitted(row.name, _OBJECTS, button=True), depress=row.name == active
            )
            distance.label(text=row.distance, translate=False)
            change.label(text=levels.change_words(row.decibels), translate=False)
        else:
            draw_pair(column, row.name, levels.change_words(row.decibels), 0.7)


def _columns(layout: UILayout) -> tuple[UILayout, UILayout, UILayout]:
    """Cells of an object of the path: name, distance, decibels."""
    split = layout.split(factor=_OBJECTS)
    rest = split.column()
    cells = split.split(factor=0.5)
    ends = cells.row(), cells.row()
    for cell in ends:
        cell.alignment = "RIGHT"
    return rest, *ends


class HAPTIC_PT_meters(ClosedPanel, Panel):
    bl_parent_id = "HAPTIC_PT_result"
    bl_label = "Meters"

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.haptics.meters, "show", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        scene = context.scene
        chosen = scene.haptics.meters
        row = layout.row(align=True)
        row.active = chosen.show
        row.prop(chosen, "show_scope", toggle=True)
        row.prop(chosen, "show_body", toggle=True)
        row.prop(chosen, "corner", text="")
        layout.prop(chosen, "show_lane")
        if sessions.shown(scene) is None:
            return
        _draw_pictures(layout, context)
        shown = watched.levels_of(scene)
        column = layout.column(align=True)
        column.scale_y = 0.8
        if shown:
            _draw_row(column, "", iface_("Peak, level"), iface_("Margin", "Haptics"))
        for level in shown:
            _draw_row(column, level.listener, level.peak_and_level(), level.margin_text())


class HAPTIC_PT_comparison(ClosedPanel, Panel):
    bl_parent_id = "HAPTIC_PT_result"
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
        grid = layout.grid_flow(
            row_major=True, columns=1 + len(Mode), even_columns=False, align=True
        )
        grid.label(text="")
        for mode in Mode:
            grid.operator(
                "haptic.set_mode", text=str(mode), depress=scene.haptics.mode == mode
            ).mode = str(mode)
        for index, listener in enumerate(result.listeners):
            grid.label(text=fitted(listener.name, 0.3), translate=False)
            for mode in Mode:
                grid.label(
                    text=_amplitude_text(amplitudes[mode].value, index)
                    if mode in amplitudes
                    else "..."
                )
        layout.label(text="Amplitude of the strongest source in dB")
        if len(amplitudes) < len(Mode) or not all(
            latest.is_current for latest in amplitudes.values()
        ):
            layout.label(text="Comparing...", icon="SORTTIME")


class HAPTIC_PT_statistics(ClosedPanel, Panel):
    bl_parent_id = "HAPTIC_PT_result"
    bl_label = "Statistics"

    def draw(self, context: Context) -> None:
        layout = self.layout
        session = sessions.known(context.scene)
        if session is None or session.shown is None:
            layout.label(text="Nothing traced yet")
            return
        result = session.shown.result
        column = layout.column(align=True)
        for stage, milliseconds in result.milliseconds.items():
            draw_pair(column, stage.replace("_", " ").capitalize(), f"{milliseconds:.2f} ms")
        draw_pair(column, "Draw", f"{session.draw_milliseconds:.2f} ms")
        column.separator()
        for name, value in result.statistics.items():
            draw_pair(column, name.replace("_", " ").capitalize(), f"{value:g}")


def draw_lane_switch(self: Header, context: Context) -> None:
    """Entry of the header of Timeline and Dope Sheet: show the lane over it."""
    if sessions.known(context.scene) is not None:
        self.layout.prop(context.scene.haptics.meters, "show_lane", text="", icon="FORCE_HARMONIC")


def _amplitude_text(amplitudes: FloatArray, index: int) -> str:
    """The amplitude that arrives at a listener in whole decibels; a dash if nothing does, or if it
    is not in the frame."""
    amplitude = float(amplitudes[index]) if index < len(amplitudes) else 0.0
    return f"{20 * math.log10(amplitude):.0f}" if amplitude > 0 else "\N{EM DASH}"


def _draw_level(layout: UILayout, level: levels.Level) -> None:
    """A listener's name, which selects it, its level as a bar, and its switches."""
    row = layout.row(align=True)
    too_weak = not level.is_silent and not level.is_felt
    text = iface_("{}, weak" if too_weak else "{}").format(levels.decibels(level.rms))
    draw_level(row, level, 0.5 * _BESIDE_SWITCHES, text)
    _draw_switches(row, level.listener, "listener")


def _draw_switches(layout: UILayout, name: str, role: str) -> None:
    """Draw solo and mute of a source or listener if it is an object of this file."""
    obj = bpy.data.objects.get(name)
    if obj is not None and getattr(obj.haptics, role).enabled:
        properties = getattr(obj.haptics, role)
        layout.prop(
            properties,
            "solo",
            text="",
            icon="SOLO_ON" if properties.solo else "SOLO_OFF",
            emboss=False,
        )
        layout.prop(
            properties,
            "muted",
            text="",
            icon="MUTE_IPO_OFF" if properties.muted else "MUTE_IPO_ON",
            emboss=False,
        )


def _draw_sources(layout: UILayout, result: FrameResult, index: int) -> None:
    """Draw the strongest sources that reach a listener."""
    strongest = sorted(
        zip(result.amplitudes[:, index], result.gains[:, index], result.sources, strict=True),
        key=lambda g: (-g[0], g[2].name),
    )
    felt = [(float(gain), source) for amplitude, gain, source in strongest if amplitude > 0]
    column = layout.box().column(align=True)
    column.scale_y = 0.8
    if felt:
        draw_pair(column, "Source", "Gain", 0.55)
    for gain, source in felt[:_SHOWN_SOURCES]:
        row = column.row(align=True)
        draw_pair(
            row,
            source_title(source, 0.55 * _BESIDE_SWITCHES),
            f"{gain:.3f}  {20 * math.log10(gain):.0f} dB",
            0.55,
        )
        _draw_switches(row, source.name, "source")
    for source in [source for source in result.sources if source.amplitude == 0][:_SHOWN_SOURCES]:
        row = column.row(align=True)
        row.label(text=source_title(source, 0.55), icon="MUTE_IPO_OFF", translate=False)
        _draw_switches(row, source.name, "source")
    if len(felt) > _SHOWN_SOURCES:
        column.label(text=iface_("and {} more").format(len(felt) - _SHOWN_SOURCES), translate=False)
    if not felt:
        column.label(text="Nothing reaches it")


def _draw_row(layout: UILayout, name: str, values: str, margin: str) -> None:
    """A listener's name, its peak and level, and its margin, in columns."""
    split = layout.split(factor=_NAMES)
    split.label(text=fitted(name, _NAMES), translate=False)
    split = split.split(factor=0.55)
    split.label(text=values, translate=False)
    split.label(text=margin, translate=False)


def _draw_pictures(layout: UILayout, context: Context) -> None:
    """Draw the scope and the body side by side, as in the viewport."""
    scene, ink = context.scene, panel_picture.theme_ink(context)
    shown, scope = watched.levels_of(scene), meters.scope_of(scene)
    body = scene.haptics.meters.show_body and any(level.body_part for level in shown)
    row = layout.row()
    if scope is not None:
        column = row.column()
        column.template_icon(icon_value=meter_pictures.scope_icon(scope, ink), scale=_PICTURE)
        full = f"±{meter_layout.full_scale(scope):.3g}"
        column.label(text=f"{fitted(scope.listener, 0.3)}, {full}", translate=False)
    if body:
        column = row.column()
        column.template_icon(icon_value=meter_pictures.body_icon(shown, ink), scale=_PICTURE)
        column.label(text="Front and back")
