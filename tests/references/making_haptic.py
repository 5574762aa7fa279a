"""Make Haptic as a user presses it."""

from __future__ import annotations

from typing import Any

import bpy


def make_haptic(*objects: Any) -> None:
    """Press *Make Haptic* with these objects selected, the first of them active."""
    bpy.context.view_layer.update()
    for obj in bpy.context.scene.objects:
        obj.select_set(obj in objects)
    bpy.context.view_layer.objects.active = objects[0]
    bpy.ops.haptic.make_objects()
