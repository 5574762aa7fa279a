"""The classes of operators, panels, menus and file handlers."""

from __future__ import annotations

import bpy

from ..blender import job
from ..operators import (
    adding,
    bake,
    body_kit,
    exporting,
    felt,
    gizmos,
    graph_to_geometry,
    importing,
    live_output,
    materials,
    modes,
    rules,
    selection,
    tagging,
    tracing,
    wishes,
)
from ..panels import bake as bake_panel
from ..panels import export, file_menus, listener, object, object_menus, preferences, result, scene, source
from ..panels import live_output as live_output_panels
from ..panels import materials as materials_panels
from ..panels import modalities as modalities_panels
from ..panels import rules as rules_panels

CLASSES = (
    *preferences.CLASSES,
    *job.CLASSES,
    *tagging.CLASSES,
    *adding.CLASSES,
    *tracing.CLASSES,
    *selection.CLASSES,
    *modes.CLASSES,
    *felt.CLASSES,
    *gizmos.CLASSES,
    *materials.CLASSES,
    *wishes.CLASSES,
    *body_kit.CLASSES,
    *rules.CLASSES,
    *bake.CLASSES,
    *exporting.CLASSES,
    *importing.CLASSES,
    *graph_to_geometry.CLASSES,
    *live_output.CLASSES,
    *scene.CLASSES,
    *object.CLASSES,
    *source.CLASSES,
    *listener.CLASSES,
    *result.CLASSES,
    *export.CLASSES,
    *materials_panels.CLASSES,
    *modalities_panels.CLASSES,
    *rules_panels.CLASSES,
    *bake_panel.CLASSES,
    *live_output_panels.CLASSES,
    *file_menus.CLASSES,
    *object_menus.CLASSES,
)
"""All of them, a panel before its subpanels."""

register, unregister = bpy.utils.register_classes_factory(CLASSES)
