"""The length of Blender's unit."""

from __future__ import annotations

from bpy.types import Scene

from .single_precision import shortest


def metres_per_unit(scene: Scene) -> float:
    """The metres that Blender shows for a unit; 1 where it shows units."""
    units = scene.unit_settings
    return 1.0 if units.system == "NONE" else shortest(units.scale_length)
