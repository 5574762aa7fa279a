"""The scene's library of haptic materials, and the materials of objects.

An object stores a copy of its material's values, so that it can be traced without a look-up and
remains valid when it is appended to another file; an edit in the library is written to all objects
of the scene with that material.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy
from bpy.props import (
    CollectionProperty,
    IntProperty,
    StringProperty,
)
from bpy.types import Context, Object, PropertyGroup, Scene

from ...core.declaration import shown
from ...core.scene.library import LibraryMaterial
from ...core.scene.materials import MATERIALS
from ..blender.progress import progress
from .callbacks import object_changed, scene_changed, updating
from .declared import holding
from .kinds import choice, text

TARGET_ITEMS = (
    ("SELECTED", "Selected", "The selected objects", "RESTRICT_SELECT_OFF", 0),
    (
        "CHILDREN",
        "Children",
        "The selected objects and everything that is parented to them",
        "OUTLINER",
        1,
    ),
    (
        "COLLECTION",
        "Collection",
        "All objects of the active object's collection",
        "OUTLINER_COLLECTION",
        2,
    ),
)

SHARED = tuple(shown(LibraryMaterial))
"""The values that materials of the library and their objects have."""


def values_of(holder: Any) -> dict[str, Any]:
    """The shared values of an object's properties, or of a material of the library."""
    return {name: getattr(holder, name) for name in SHARED}


def write_values(obj: Object, values: dict[str, Any]) -> None:
    """Give an object the values of a material; equal values are not written."""
    for name, value in values.items():
        if getattr(obj.haptics, name) != value:
            setattr(obj.haptics, name, value)


def made_of(scene: Scene, name: str) -> Iterator[Object]:
    """The editable objects of a scene that are made of the library material of this name; none if
    the name is empty."""
    objects = scene.objects if name else ()
    return (obj for obj in objects if obj.haptics.material.name == name and obj.is_editable)


def _material_changed(self: HapticMaterial, context: Context) -> None:
    values = values_of(self)
    for obj in progress(list(made_of(self.id_data, self.known_as))):
        write_values(obj, values)


def _material_renamed(self: HapticMaterial, context: Context) -> None:
    if self.name == self.known_as:
        return
    scene = self.id_data
    taken = {item.name for item in scene.haptics.materials.items if item != self}
    name = unique_name(self.name or self.known_as, taken)
    for obj in progress(list(made_of(scene, self.known_as))):
        obj.haptics.material.name = name
    self.known_as = name
    if self.name != name:
        self.name = name


def unique_name(name: str, taken: set[str]) -> str:
    """The name, or the name with the first free number, as in Blender."""
    if name not in taken:
        return name
    stem, _, number = name.rpartition(".")
    stem = stem if stem and number.isdigit() else name
    return next(
        candidate for k in range(1, len(taken) + 2) if (candidate := f"{stem}.{k:03d}") not in taken
    )


@updating(_material_changed, animated=False)
@holding(LibraryMaterial)
class HapticMaterial(PropertyGroup):
    """A material of the scene's library."""

    reasons = {"wave_speed": "long bodies, in which vibration takes its time"}

    name: text("Name", "Name of the material in this scene's library", update=_material_renamed)
    known_as: StringProperty(options={"HIDDEN"})


def _chosen(self: HapticObjectMaterial, context: Context) -> None:
    """Copy the values of the chosen material to the object."""
    obj, scene = self.id_data, context.scene
    # In the order of cost: look-ups by name search the objects of a view layer, `users_scene` those
    # of every scene.
    layers = scene.view_layers
    is_here = (
        any(
            obj.visible_get(view_layer=layer) or layer.objects.get(obj.name) == obj
            for layer in layers
        )
        or scene in obj.users_scene
    )
    if (
        self.name
        and is_here
        and (material := scene.haptics.materials.items.get(self.name)) is not None
    ):
        write_values(obj, values_of(material))
    object_changed(self, context)
    scene_changed(self, context)  # rules may be of the material


@updating(object_changed)
class HapticObjectMaterial(PropertyGroup):
    """The material of an object."""

    name: text(
        "Material",
        "The material of the scene's library that this object is made of",
        options=set(),
        update=_chosen,
    )


PRESET_ITEMS = tuple((material.name, material.title, "") for material in MATERIALS.values())


class HapticMaterialName(PropertyGroup):
    """What the objects of a Blender material, or of a name, are made of; `name` is its name."""

    preset: choice(
        "Material",
        "The material that Make Haptic gives objects of this name",
        (("NONE", "Not Known", ""), *PRESET_ITEMS),
        options=set(),
    )


class HapticMaterialLibrary(PropertyGroup):
    """The haptic materials of a scene. ``names``: what names of Blender materials, objects and
    collections stand for."""

    reasons = {"active": "view", "target": "view"}

    items: CollectionProperty(type=HapticMaterial)  # type: ignore[assignment]  # in place of items() of bpy_struct
    names: CollectionProperty(type=HapticMaterialName)
    active: IntProperty(name="Active Material", default=0, min=0, options=set())
    target: choice("Apply To", "What a material is applied to", TARGET_ITEMS, options=set())


def add_material(scene: Scene, name: str, values: dict[str, object]) -> HapticMaterial:
    """A new material of the scene's library, which gets a number if its name is taken."""
    library = scene.haptics.materials
    name = unique_name(name, {item.name for item in library.items})
    item = library.items.add()
    for key, value in values.items():  # before it has a name, by which objects would be looked for
        setattr(item, key, value)
    item.known_as = name
    item.name = name
    if values:
        _material_changed(item, bpy.context)
    library.active = len(library.items) - 1
    return item
