"""The add-on's panel in the sidebars of Blender's glTF exporter and importer."""

from __future__ import annotations

from bpy.types import Context, UILayout


def draw_export(context: Context, layout: UILayout) -> None:
    """The panel in the exporter's sidebar."""
    header, body = layout.panel("haptic_tracing_gltf", default_closed=False)
    header.label(text="Haptic Tracing")
    if body is None:
        return
    properties = context.scene.haptics.gltf
    body.use_property_split = True
    body.prop(properties, "use_extras")
    body.prop(properties, "use_material")
    if properties.use_material:
        body.prop(properties, "material_name")


def draw_import(context: Context, layout: UILayout) -> None:
    """Draw nothing: the add-on has no import options."""
