"""Export of the scene's library of haptic materials."""

from __future__ import annotations

from collections.abc import Iterable

import bpy
from bpy.types import Scene

from ...core.scene.library import LibraryMaterial
from ...core.scene.values import HapticObject
from ..blender.single_precision import authored
from ..properties.declared import read_values
from ..properties.materials import HapticMaterial, values_of


def written_materials(
    scene: Scene, objects: Iterable[HapticObject], whole: bool
) -> tuple[LibraryMaterial, ...]:
    """The materials of the library, all of them (``whole``) or only those of ``objects``, followed
    by those that objects name but the library lacks, with the values of the first such object."""
    named: dict[str, str] = {}
    for item in objects:
        if item.material:
            named.setdefault(item.material, item.name)
    items = scene.haptics.materials.items
    known = [_material(item) for item in items if whole or item.name in named]
    others = [
        LibraryMaterial(
            name,
            **{
                key: authored(value)
                for key, value in values_of(bpy.data.objects[owner].haptics).items()
            },
        )
        for name, owner in named.items()
        if name not in items and owner in bpy.data.objects
    ]
    return (*known, *others)


def _material(item: HapticMaterial) -> LibraryMaterial:
    return LibraryMaterial(item.name, **read_values(LibraryMaterial, item))
