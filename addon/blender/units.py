"""The length of Blender's unit."""

from __future__ import annotations

from bpy.types import Scene

from .single_precision import shortest


def metres_per_unit(scene: Scene) -> float:
    """The metres that Blender shows for a unit; 1 in a scene that does not use its unit scale, as
    those of earlier versions."""
    units = scene.unit_settings
    follows = scene.haptics.use_unit_scale and units.system != "NONE"
    return shortest(units.scale_length) if follows else 1.0
