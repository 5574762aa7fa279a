"""Export and import of the scene's library of haptic materials."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, fields
from typing import Any

import bpy
from bpy.types import Scene

from ...core.formats.scene.lists_json import LibraryMaterial
from ...core.scene.values import HapticObject
from ..blender.single_precision import authored
from ..properties.materials import add_material, own_values

_KEYS = tuple(item.name for item in fields(LibraryMaterial) if item.name != "name")


def written_materials(scene: Scene, objects: Iterable[HapticObject], whole: bool) -> tuple[LibraryMaterial, ...]:
    """The materials of the library, all of them (``whole``) or only those of ``objects``, followed by those that objects name but the
    library lacks, with the values of the first such object."""
    named: dict[str, str] = {}
    for item in objects:
        if item.material:
            named.setdefault(item.material, item.name)
    items = scene.haptics.materials.items
    known = [_material(item.name, {key: getattr(item, key) for key in _KEYS}) for item in items if whole or item.name in named]
    others = [
        _material(name, own_values(bpy.data.objects[owner]))
        for name, owner in named.items()
        if name not in items and owner in bpy.data.objects
    ]
    return (*known, *others)


def take_materials(scene: Scene, materials: Sequence[LibraryMaterial]) -> list[str]:
    """Add ``materials`` to a scene's library. Existing ones of the same name are kept, and their names are returned if they differ."""
    other = []
    for material in materials:
        values = {key: value for key, value in asdict(material).items() if key != "name"}
        known = scene.haptics.materials.items.get(material.name)
        if known is None:
            add_material(scene, material.name, values)
        elif _material(material.name, {key: getattr(known, key) for key in _KEYS}) != _material(material.name, values):
            other.append(material.name)
    return other


def _material(name: str, values: Mapping[str, Any]) -> LibraryMaterial:
    return LibraryMaterial(name, **{key: authored(values[key]) for key in _KEYS})
