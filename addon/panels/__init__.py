"""The sidebar tab "Haptics". Panels read properties and the last result; they compute nothing."""

from __future__ import annotations

import bpy

from . import export, listener, object, result, scene, source

CLASSES = tuple(cls for module in (scene, object, source, listener, result, export) for cls in module.CLASSES)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
