"""The sidebar tab "Haptics". Panels read properties and the last result; they compute nothing."""

from __future__ import annotations

import bpy

from . import export, listener, object, result, scene, source

CLASSES = tuple(cls for module in (scene, object, source, listener, result, export) for cls in module.CLASSES)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
