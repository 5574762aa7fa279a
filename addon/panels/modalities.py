"""Panels of the modalities other than vibration, generated from their definitions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bpy.types import Context, Panel, UILayout

from ...core.modalities import MODALITIES, Modality
from ..blender.words import show
from ..session import sessions
from .drawing import ObjectPanel, ScenePanel, draw_carrier, settings_layout
from .formula import draw_parameters

if TYPE_CHECKING:
    from ...core.modalities.propagation import Felt


def _scene_panel(modality: Modality) -> type[Panel]:
    """The panel of a modality in the scene: its switch, and the values at listeners."""

    def draw_header(self: Panel, context: Context) -> None:
        self.layout.prop(
            getattr(context.scene.haptics.modalities, modality.name), "enabled", text=""
        )

    def draw(self: Panel, context: Context) -> None:
        layout = self.layout
        layout.active = getattr(context.scene.haptics.modalities, modality.name).enabled
        felt = next(
            (felt for felt in sessions.felt_in(context.scene) if felt.modality is modality), None
        )
        if felt is None:
            layout.label(text="Switch it on and trace a frame", icon="INFO")
        elif not felt.emitters:
            layout.label(text="No source: make an object one in its tab", icon="INFO")
        else:
            column = layout.column(align=True)
            for index in range(len(felt.listeners)):
                _draw_listener(column, felt, index)

    return _panel(modality, "scene", ScenePanel, {"draw_header": draw_header, "draw": draw})


def _draw_listener(layout: UILayout, felt: Felt, index: int) -> None:
    value = float(felt.values[index])
    row = layout.split(factor=0.72)
    show(row, felt.listeners[index])
    side = row.row()
    side.alignment = "RIGHT"
    show(side, f"{value:+.1f} {felt.modality.source_value.unit}")
    words = felt.modality.sensation(value)
    if words:
        layout.label(text=words, icon="BLANK1")


def _object_panel(modality: Modality) -> type[Panel]:
    """The panel of a modality for the active object: its function and values, and its source."""

    def poll(cls: type[Panel], context: Context) -> bool:
        return context.object is not None and context.object.type != "ARMATURE"

    def draw(self: Panel, context: Context) -> None:
        layout = settings_layout(self, is_animated=True)
        obj: Any = context.object
        group = getattr(obj.haptics.modalities, modality.name)
        if obj.haptics.enabled:
            layout.prop(group, "function")
            draw_parameters(layout, group, 0.0, 1.0, context.scene.haptics.epsilon)
        layout.prop(group, "is_source")
        if group.is_source:
            layout.prop(group, "source_value")
            draw_carrier(layout, obj, "Goes into")

    return _panel(modality, "object", ObjectPanel, {"poll": classmethod(poll), "draw": draw})


def _panel(
    modality: Modality, part: str, kind: type[ScenePanel], values: dict[str, object]
) -> type[Panel]:
    name = f"HAPTIC_PT_{modality.name}_{part}"
    given = {"bl_idname": name, "bl_label": modality.title, "__module__": __name__, **values}
    return type(name, (kind,), given)


PANELS = tuple(
    panel(modality) for modality in MODALITIES.values() for panel in (_scene_panel, _object_panel)
)
