"""Panels of the modalities other than vibration, generated from their definitions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from bpy.types import Context, UILayout

from ...core.modalities import MODALITIES, Modality
from ..blender.words import show_pair
from ..session import sessions
from .drawing import ObjectPanel, ScenePanel, draw_carrier, settings_layout
from .formula import draw_parameters

if TYPE_CHECKING:
    from ...core.modalities.propagation import Felt


class _ScenePanel(ScenePanel):
    """The panel of a modality in the scene: its switch, and the values at listeners."""

    modality: ClassVar[Modality]

    def draw_header(self, context: Context) -> None:
        self.layout.prop(_properties(self, context.scene), "enabled", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.active = _properties(self, context.scene).enabled
        felt = next(
            (felt for felt in sessions.felt_in(context.scene) if felt.modality is self.modality),
            None,
        )
        if felt is None:
            layout.label(text="Switch it on and trace a frame", icon="INFO")
        elif not felt.emitters:
            layout.label(text="No source: make an object one in its tab", icon="INFO")
        else:
            column = layout.column(align=True)
            for index in range(len(felt.listeners)):
                _draw_listener(column, felt, index)


class _ObjectPanel(ObjectPanel):
    """The panel of a modality for the active object: its function and values, and its source."""

    modality: ClassVar[Modality]

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.object is not None and context.object.type != "ARMATURE"

    def draw(self, context: Context) -> None:
        layout = settings_layout(self, is_animated=True)
        obj: Any = context.object
        group = _properties(self, obj)
        if obj.haptics.enabled:
            layout.prop(group, "function")
            draw_parameters(layout, group, 0.0, 1.0, context.scene.haptics.epsilon)
        layout.prop(group, "is_source")
        if group.is_source:
            layout.prop(group, "source_value")
            draw_carrier(layout, obj, "Goes into")


def _properties(panel: _ScenePanel | _ObjectPanel, owner: Any) -> Any:
    """The properties of the panel's modality of a scene or an object."""
    return getattr(owner.haptics.modalities, panel.modality.name)


def _draw_listener(layout: UILayout, felt: Felt, index: int) -> None:
    value = float(felt.values[index])
    unit = felt.modality.source_value.unit
    show_pair(layout, felt.listeners[index], f"{value:+.1f} {unit}", 0.72)
    words = felt.modality.sensation(value)
    if words:
        layout.label(text=words, icon="BLANK1")


PANELS = tuple(
    type(
        f"HAPTIC_PT_{modality.name}_{part}",
        (base,),
        {"bl_label": modality.title, "modality": modality, "__module__": __name__},
    )
    for modality in MODALITIES.values()
    for part, base in (("scene", _ScenePanel), ("object", _ObjectPanel))
)
