"""Materials of a scene's library, and their assignment to objects."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import bpy
from bpy.types import Context, Object, Scene

from ...core.scene.materials import MATERIALS, Material, guess
from ...core.scene.measured import physical
from ...core.scene.skeleton import part_in
from ..blender.progress import progress
from ..properties import materials
from ..properties.declared import write_values
from ..properties.materials import SHARED, HapticMaterial, add_material, values_of
from .sizes import sizes_of


def spread_all_around(haptics: Any, radius: float) -> None:
    """Give a medium spherical spreading without loss: at a distance d [m], the gain is ``radius`` / (``radius`` + d)."""
    haptics.function, haptics.wave, haptics.reference_distance = "physical", "solid", radius
    haptics.loss_factor = haptics.absorption = haptics.extent = 0.0
    haptics.material_k = (1.0 - haptics.kappa) * haptics.rho  # so that a decay set later is not scaled


def preset_values(material: Material) -> dict[str, object]:
    """The values of a preset, in the form of the library."""
    values = {name: getattr(material, name) for name in SHARED if name != "use_bands"}
    return {**values, "use_bands": False}  # initially only the paper's function, whose gains the overlay shows


def preset_in(scene: Scene, material: Material) -> HapticMaterial:
    """The library's material with the preset's title, added if missing."""
    return scene.haptics.materials.items.get(material.title) or add_material(scene, material.title, preset_values(material))


def apply(objects: Sequence[Object], item: HapticMaterial) -> None:
    """Assign a material to objects: they take its values, now and when it changes."""
    name, values = item.name, values_of(item)
    for obj in progress(objects):
        materials.write_values(obj, values)
        if obj.haptics.material.name != name:
            obj.haptics.material.name = name


def copy(scene: Scene, item: HapticMaterial) -> HapticMaterial:
    """A copy in the library, not assigned to any object."""
    values = {**values_of(item), "wave_speed": item.wave_speed, "use_delay": item.use_delay}
    return add_material(scene, item.name, values)


def preset_of(obj: Object) -> Material | None:
    """The preset from which an object's library material was made, found by its title."""
    title = obj.haptics.material.name.partition(".")[0]
    return next((material for material in MATERIALS.values() if material.title == title), None)


def make_physical(objects: Iterable[Object], in_a_building: bool) -> int:
    """Give objects made of a preset the measured physical function; half-spaces stay such. Returns their number."""
    known, depsgraph = 0, bpy.context.evaluated_depsgraph_get()
    for obj in objects:
        material = preset_of(obj)
        if material is None:
            continue
        known += 1
        is_half_space = (obj.haptics.function, obj.haptics.wave) == ("physical", "surface")
        obj.haptics.function = "physical"
        form = physical(material.name, sizes_of(obj, depsgraph), in_a_building, part_in(obj.name), is_half_space)
        write_values(obj.haptics, form)
    return known


def set_bodies(objects: Iterable[Object], function: str) -> int:
    """Set the function of those of ``objects`` that are made of flesh: measured ("physical") or the paper's ("haptic_tracing"). Returns
    their number."""
    bodies = [obj for obj in objects if preset_of(obj) is MATERIALS["flesh"]]
    if function == "physical":
        return make_physical(bodies, False)
    for obj in bodies:
        obj.haptics.function = function
    return len(bodies)


def targets(context: Context, target: str) -> list[Object]:
    """The editable objects with a surface among the "selected" ones, their "children" or those of the "collection"."""
    match target:
        case "CHILDREN":
            found = {child for obj in context.selected_objects for child in (obj, *obj.children_recursive)}
            objects: Iterable[Object] = (obj for obj in context.view_layer.objects if obj in found)
        case "COLLECTION":
            objects = context.object.users_collection[0].all_objects if context.object and context.object.users_collection else ()
        case _:
            objects = context.selected_objects
    return list(objects)


def guessed(obj: Object) -> Material | None:
    """The probable material of an object, by the names of its surfaces, of itself and of its mesh, its shape and its mass."""
    names = [slot.material.name for slot in obj.material_slots if slot.material is not None]
    names += [obj.name] + ([obj.data.name] if obj.data is not None else [])
    body = obj.rigid_body
    mass = body.mass if body is not None and body.mass != 1.0 else None  # 1 kg is Blender's default
    return guess(names, tuple(obj.dimensions), mass)


def apply_guesses(scene: Scene, objects: Sequence[Object]) -> int:
    """Assign the guessed materials to objects. Returns how many could be guessed."""
    known = 0
    for obj in progress(objects):
        material = guessed(obj)
        if material is not None:
            apply([obj], preset_in(scene, material))
            known += 1
    return known
