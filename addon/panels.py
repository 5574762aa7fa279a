"""The sidebar tab "Haptics". Panels read properties and the last result; they compute nothing."""

from __future__ import annotations

import math
from typing import Any

import bpy
from bpy.types import Context, Object, Panel, UILayout

from ..core.frame_result import FrameResult
from . import session
from .scene_reader import haptic_carrier

_SHOWN_PROBLEMS = 5
_SHOWN_SOURCES = 4


class _HapticsPanel:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Haptics"


class HAPTIC_PT_scene(_HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_scene"
    bl_label = "Haptic Tracing"

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.haptics, "tracing", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        column = layout.column(align=True)
        column.operator("haptic.make_objects", icon="OUTLINER_OB_META")
        row = column.row(align=True)
        row.operator("haptic.add_source", icon="OUTLINER_OB_FORCE_FIELD")
        row.operator("haptic.add_listener", icon="OUTLINER_OB_LIGHTPROBE")
        column.operator("haptic.add_default_listeners", icon="OUTLINER_OB_ARMATURE")
        _draw_problems(layout, context)


class HAPTIC_PT_propagation(_HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_propagation"
    bl_parent_id = "HAPTIC_PT_scene"
    bl_label = "Propagation"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        haptics = context.scene.haptics
        layout.prop(haptics, "mode")
        layout.prop(haptics, "strategy")
        column = layout.column(align=True)
        column.prop(haptics, "threshold")
        column.prop(haptics, "max_connections")
        column.prop(haptics, "epsilon")
        layout.prop(haptics, "contact_tolerance")


class HAPTIC_PT_impacts(_HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_impacts"
    bl_parent_id = "HAPTIC_PT_scene"
    bl_label = "Impacts"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.haptics, "impacts", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        haptics = context.scene.haptics
        layout.active = haptics.impacts
        column = layout.column(align=True)
        column.prop(haptics, "minimum_energy")
        column.prop(haptics, "maximum_energy")


class HAPTIC_PT_overlay(_HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_overlay"
    bl_parent_id = "HAPTIC_PT_scene"
    bl_label = "Overlay"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.haptics, "show_overlay", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        haptics = context.scene.haptics
        layout.active = haptics.show_overlay
        column = layout.column(align=True)
        column.prop(haptics, "show_intra")
        column.prop(haptics, "show_best_paths")
        column.prop(haptics, "show_labels")
        column.prop(haptics, "show_flow")
        column.prop(haptics, "xray")
        layout.operator("haptic.graph_to_geometry", icon="MESH_DATA")


class HAPTIC_PT_object(_HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_object"
    bl_label = "Haptic Object"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.object is not None

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.object.haptics, "enabled", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        obj = context.object
        haptics = obj.haptics
        layout.active = haptics.enabled
        layout.label(text=obj.name, icon="OBJECT_DATA")
        column = layout.column(align=True)
        column.prop(haptics, "kappa")
        column.prop(haptics, "rho")
        _draw_function(layout, haptics)
        column = layout.column()
        column.prop(haptics, "wave_speed")
        column.prop(haptics, "medium")
        if haptics.enabled and obj.rigid_body is not None and context.scene.rigidbody_world is None:
            _warn(layout, "This rigid body does not move:", "the scene has no Rigid Body World")


class HAPTIC_PT_source(_HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_source"
    bl_label = "Haptic Source"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.object is not None

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.object.haptics.source, "enabled", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        source = context.object.haptics.source
        layout.active = source.enabled
        layout.prop(source, "amplitude")
        layout.prop(source, "signal")
        if source.signal == "FILE":
            layout.prop(source, "filepath")
        elif source.signal != "NOISE":
            layout.prop(source, "frequency")
        layout.prop(source, "priority")
        layout.prop(source, "muted")
        _draw_carrier(layout, context.object, source.enabled, "Shakes")


class HAPTIC_PT_listener(_HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_listener"
    bl_label = "Haptic Listener"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.object is not None

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.object.haptics.listener, "enabled", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        listener = context.object.haptics.listener
        layout.active = listener.enabled
        layout.prop(listener, "body_part")
        layout.prop(listener, "radius")
        layout.prop(listener, "mixing")
        column = layout.column(align=True)
        column.prop(listener, "gain")
        column.prop(listener, "s_max")
        _draw_carrier(layout, context.object, listener.enabled, "Feels")


class HAPTIC_PT_result(_HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_result"
    bl_label = "Result"

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


class HAPTIC_PT_statistics(_HapticsPanel, Panel):
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
            _draw_pair(column, stage.replace("_", " ").title(), f"{milliseconds:.2f} ms")
        column.separator()
        for name, value in result.statistics.items():
            _draw_pair(column, name.replace("_", " ").capitalize(), f"{value:g}")


class HAPTIC_PT_export(_HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_export"
    bl_label = "Export"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        self.layout.operator("export_scene.haptic_scene", icon="EXPORT")


def _draw_function(layout: UILayout, haptics: Any) -> None:
    layout.prop(haptics, "function")
    parameter = {"exponential": "alpha", "linear": "range", "constant": "constant", "expression": "expression"}.get(haptics.function)
    if parameter is not None:
        layout.prop(haptics, parameter)


def _draw_carrier(layout: UILayout, obj: Object, enabled: bool, verb: str) -> None:
    if not enabled:
        return
    carrier = haptic_carrier(obj)
    if carrier is None:
        _warn(layout, "Not on a haptic object:", "make it haptic or parent it to one")
    elif carrier != obj:
        layout.label(text=f"{verb} {carrier.name}", icon="LINKED")


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
        _draw_pair(column, source, f"{gain:.3f}  {20 * math.log10(gain):.0f} dB")
    if len(felt) > _SHOWN_SOURCES:
        column.label(text=f"and {len(felt) - _SHOWN_SOURCES} more")
    if not felt:
        column.label(text="Nothing reaches it")


def _draw_pair(layout: UILayout, name: str, value: str) -> None:
    split = layout.split(factor=0.6)
    split.label(text=name)
    row = split.row()
    row.alignment = "RIGHT"
    row.label(text=value)


def _warn(layout: UILayout, *lines: str) -> None:
    column = layout.column(align=True)
    for number, line in enumerate(lines):
        column.label(text=line, icon="ERROR" if number == 0 else "BLANK1")


def _draw_problems(layout: UILayout, context: Context) -> None:
    problems = session.problems_of(context.scene)
    if not problems:
        return
    box = layout.box()
    box.label(text=f"{len(problems)} problem{'s' if len(problems) > 1 else ''}", icon="ERROR")
    for problem in problems[:_SHOWN_PROBLEMS]:
        column = box.column(align=True)
        if problem.object:
            column.operator("haptic.select_object", text=problem.object, icon="RESTRICT_SELECT_OFF").name = problem.object
        for line in _wrapped(problem.message):
            column.label(text=line)


def _wrapped(text: str, width: int = 40) -> list[str]:
    import textwrap

    return textwrap.wrap(text[:1].upper() + text[1:], width)


CLASSES = (
    HAPTIC_PT_scene,
    HAPTIC_PT_propagation,
    HAPTIC_PT_impacts,
    HAPTIC_PT_overlay,
    HAPTIC_PT_object,
    HAPTIC_PT_source,
    HAPTIC_PT_listener,
    HAPTIC_PT_result,
    HAPTIC_PT_statistics,
    HAPTIC_PT_export,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
