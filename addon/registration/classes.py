"""The classes of operators, panels, menus and file handlers."""

from __future__ import annotations

import bpy

from ..blender import job
from ..operators import (
    adding,
    bake,
    body_kit,
    design,
    exporting,
    importing,
    live_output,
    materials,
    rules,
    signals,
    tagging,
    tracing,
)
from ..panels import bake as bake_panel
from ..panels import (
    export,
    listener,
    object,
    object_menus,
    output,
    preferences,
    quick_start,
    result,
    roles,
    scene,
    settings,
    source,
)
from ..panels import live_output as live_output_panels
from ..panels import materials as materials_panels
from ..panels import rules as rules_panels
from ..panels import sound as sound_panels
from .properties import classes_of

CLASSES = (
    *classes_of(
        *(preferences, job, tagging, adding, tracing, design),
        *(materials, body_kit, rules),
    ),
    *classes_of(
        bake,
        exporting,
        importing,
        signals,
        live_output,
        quick_start,
        scene,
        settings,
        object,
        source,
        sound_panels,
        listener,
        roles,
        result,
        output,
        export,
    ),
    *classes_of(materials_panels),
    *classes_of(rules_panels, bake_panel, live_output_panels, object_menus),
)
"""All classes, a panel before its subpanels."""

_register, unregister = bpy.utils.register_classes_factory(CLASSES)


def register() -> None:
    """Register them, those completed that depend on the formats that there are."""
    for cls in CLASSES:
        if hasattr(cls, "complete"):
            cls.complete()
    _register()
