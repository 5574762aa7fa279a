"""Panel "Haptic Source": what the active object emits."""

from __future__ import annotations

from bpy.types import Context, Object, Panel, Scene, UILayout

from ...core.scene.values import Source
from ..io import signal_library
from ..properties.drawing import AMPLITUDE, FREQUENCY
from ..properties.signal_kinds import PLAIN
from ..properties.source import HapticSourceProperties
from ..scene_reader.roles import haptic_carrier
from ..session import sessions
from .cures import draw_file
from .drawing import (
    ObjectPanel,
    draw_carrier,
    draw_each,
    draw_held,
    draw_properties,
    poll_object,
    settings_layout,
)
from .object import draw_wave_speed, library_owner
from .texts import draw_sentence
from .thumbnails import cell

_SHOWN_EMPHASES = 20
_TRIGGERS = {
    "": "",
    "_markers": "timeline_markers",
}
"""Suffixes of property names, and the collections that these properties name items of."""


class HAPTIC_PT_signals(Panel):
    """The signal library, beside the choice of a signal."""

    bl_label = "Signals"
    bl_space_type = "VIEW_3D"
    bl_region_type = "HEADER"
    bl_options = {"INSTANCED"}
    bl_ui_units_x = 22

    poll = classmethod(poll_object)

    def draw(self, context: Context) -> None:
        flow = self.layout.grid_flow(row_major=True, columns=4, even_columns=True)
        for kind in PLAIN:
            cell(flow, f"signal-{kind}").prop_enum(context.object.haptics.source, "signal", kind)
        for path in signal_library.files():
            name, pixels = signal_library.picture(path)
            row = cell(flow, name, pixels).row(align=True)
            row.operator("haptic.use_signal", text=path.stem).filepath = str(path)
            row.operator("haptic.hear_signal", text="", icon="PLAY").filepath = str(path)
        self.layout.operator("haptic.save_signal", icon="FILE_TICK")


def draw_drawing(layout: UILayout, obj: Object) -> None:
    """Draw the curves of a source's drawn signal."""
    source = obj.haptics.source
    layout.template_ID(source, "drawing", new="haptic.draw_signal")
    tree = source.drawing
    if tree is None:
        return
    for name in (AMPLITUDE, FREQUENCY):
        node = tree.nodes.get(name)
        if node is not None and node.bl_idname == "ShaderNodeFloatCurve":
            layout.label(text=name)
            layout.template_curve_mapping(node, "mapping")
    drawing = tree.haptics
    draw_properties(layout, drawing, "lowest", "highest")
    draw_each(layout, drawing, "duration", "loops")
    column = layout.column(align=True)
    column.use_property_split = False
    column.operator("haptic.edit_emphasis", icon="ADD").index = -1
    if drawing.emphases:
        row = column.row()
        for name in ("Place", "Strength", "Sharpness"):
            row.label(text=name)
    for number, emphasis in enumerate(drawing.emphases[:_SHOWN_EMPHASES]):
        row = column.row(align=True)
        draw_each(row, emphasis, "place", "strength", "sharpness", text="")
        row.operator("haptic.edit_emphasis", text="", icon="X").index = number


class HAPTIC_PT_source(ObjectPanel):
    bl_label = "Haptic Source"

    poll = classmethod(poll_object)

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.object.haptics.source, "enabled", text="")

    def draw(self, context: Context) -> None:
        layout = settings_layout(self, is_animated=True)
        source = context.object.haptics.source
        if not source.enabled:
            return
        draw_signal(layout, source)
        if source.signal == "DRAWN":
            draw_drawing(layout, context.object)
        _draw_faults(layout, context.scene, context.object, "signal")
        layout.operator("haptic.import_signal", icon="IMPORT")
        layout.prop(source, "decay")
        draw_held(layout, source, Source, amplitude=None)
        layout.prop(source, "muted")
        draw_carrier(layout, context.object, "Shakes")
        layout.prop(source, "one_shot")
        if source.one_shot:
            _draw_triggers(layout.column(), context.scene, context.object)
        row = layout.row(align=True)
        row.operator("haptic.make_one_shot", text="Explosion").kind = "EXPLOSION"
        row.operator("haptic.make_one_shot", text="Gun").kind = "GUN"
        carrier = haptic_carrier(context.object)
        if (
            carrier is not None
            and carrier.haptics.medium
            and carrier.haptics.function == "physical"
        ):
            _draw_front(layout, context, carrier)


def draw_signal(layout: UILayout, source: HapticSourceProperties) -> None:
    """Draw how strong a source is, what it emits, and the frequency where that is a number."""
    layout.prop(source, "amplitude")
    row = layout.row(align=True)
    row.prop(source, "signal")
    row.popover("HAPTIC_PT_signals", text="", icon="IMGDISPLAY")
    row.operator("haptic.hear_signal", text="", icon="PLAY_SOUND").filepath = ""
    if source.signal in PLAIN and PLAIN[source.signal].is_tuned:
        layout.prop(source, "frequency")
    if source.signal in ("FILE", "SOUND"):
        draw_file(layout, source)


def _draw_triggers(layout: UILayout, scene: Scene, obj: Object) -> None:
    """Draw what triggers a source, each with its faults."""
    for end, items in _TRIGGERS.items():
        name = f"trigger{end}"
        if items:
            layout.prop_search(obj.haptics.source, name, scene, items, results_are_suggestions=True)
        else:
            layout.prop(obj.haptics.source, name)
        _draw_faults(layout, scene, obj, name)


def _draw_front(layout: UILayout, context: Context, medium: Object) -> None:
    """Draw how fronts spread in a medium."""
    haptics = medium.haptics
    column = layout.column(align=True)
    draw_wave_speed(column, haptics, library_owner(context, medium))
    column.prop(haptics, "absorption", text="Decay (1/m)")
    column.prop(haptics, "reference_distance", text="Radius")


def _draw_faults(layout: UILayout, scene: Scene, obj: Object, name: str) -> None:
    """Draw the faults of a property of the source."""
    for problem in sessions.shown_problems(scene):
        if (problem.object, problem.rule) == (obj.name_full, (name, 0)):
            draw_sentence(layout, problem.message, "ERROR")
