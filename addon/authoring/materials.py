"""Materials of a scene's library, and their assignment to objects."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import bpy
from bpy.types import Collection, Context, Object, Scene

from ...core.scene.coefficients import transfer_coefficient
from ...core.scene.materials import MATERIALS, Material, guess, preset_named
from ...core.scene.measured import DAMPING, SPRINGS, felt_all_over, function_of
from ...core.scene.skeleton import part_in
from ..blender.progress import progress
from ..blender.units import metres_per_unit
from ..changes.suspension import suspended
from ..properties import materials
from ..properties.declared import held_values, write_values
from ..properties.materials import HapticMaterial, add_material, values_of
from ..properties.object import HapticObjectProperties
from ..scene_reader.objects import mass_of
from .sizes import Sizes

_BOUNDLESS = 1e6
"""Thickness and width [m] of what waves never fill."""
_FLESH = MATERIALS["flesh"]
_PLASTIC = MATERIALS["plastic"]
_OF_ROBOTS = re.compile(r"(?i)(?<![a-z])(robot|urdf|gripper|(base_?)?links?|joint)(?![a-z])")


def spread_all_around(haptics: Any, radius: float) -> None:
    """Give a medium spherical spreading without loss: at a distance d [m], the gain is ``radius`` /
    (``radius`` + d)."""
    haptics.function, haptics.wave, haptics.reference_distance = "physical", "bounded", radius
    haptics.loss_factor = haptics.absorption = 0.0
    haptics.plate_thickness = haptics.extent = _BOUNDLESS
    # So that a decay set later is not scaled.
    haptics.material_k = (1.0 - haptics.kappa) * haptics.rho


def preset_values(material: Material) -> dict[str, object]:
    """The values of a preset, in the form of the library."""
    return {"kappa": material.kappa, "rho": material.rho}


def preset_in(scene: Scene, material: Material) -> HapticMaterial:
    """The library's material with the preset's title, added if missing."""
    return scene.haptics.materials.items.get(material.title) or add_material(
        scene, material.title, preset_values(material)
    )


def apply(objects: Sequence[Object], item: HapticMaterial, sizes: Sizes | None = None) -> None:
    """Assign a material to objects: they take its values, now and when it changes; physical ones
    also the damping of a preset, by their ``sizes``."""
    physical = [obj for obj in objects if obj.haptics.function in ("physical", "resilient")]
    sizes = sizes or Sizes(physical)  # before a property changes
    values = values_of(item)
    name = item.name
    for obj in progress(objects):
        materials.write_values(obj, values)
        if obj.haptics.material.name != name:
            known = preset_of(obj)
            if (
                known is not None
                and (known is _FLESH or (known.name in DAMPING and DAMPING[known.name].ground))
                and obj.haptics.function == "physical"
            ):
                obj.haptics.wave = "bounded"  # or the next material would stay a half-space
            obj.haptics.material.name = name
    make_physical(physical, sizes=sizes)


def make_haptic(scene: Scene, made_of: Mapping[Object, Material | None]) -> None:
    """Make objects haptic, each of a preset or, with None, of the material that it has, without one
    of plastic. Their function is physical, unless one was chosen or the scene is as in the
    paper."""
    is_physical = scene.haptics.strategy != "as_in_the_paper"
    made_of = {
        obj: material or (None if obj.haptics.material.name else _PLASTIC)
        for obj, material in made_of.items()
    }
    sizes = Sizes(made_of)
    new = [obj for obj in made_of if not obj.haptics.is_property_set("function")]
    for obj in new:
        obj.haptics.function = "physical" if is_physical else "haptic_tracing"
    for obj in made_of:
        obj.haptics.enabled = True
    _apply_presets(scene, made_of, sizes)
    if is_physical:
        for obj in new:
            _damp(obj, preset_of(obj), sizes)


def become_haptic(obj: Object) -> None:
    """Give an object that a script or its switch makes haptic what *Make Haptic* gives, but κ and
    ρ that it has already."""
    scene, haptics = bpy.context.scene, obj.haptics
    own = {key: getattr(haptics, key) for key in ("kappa", "rho") if haptics.is_property_set(key)}
    chosen = preset_of(obj) if haptics.material.name else guesses([obj])[obj]
    with suspended():
        make_haptic(scene, {obj: chosen})
    for key, value in own.items():
        setattr(haptics, key, value)


def preset_of(obj: Object) -> Material | None:
    """The preset from which an object's library material was made, found by its title."""
    return preset_named(obj.haptics.material.name)


def make_physical(
    objects: Iterable[Object], in_a_building: bool = False, sizes: Sizes | None = None
) -> int:
    """Give objects made of a preset the measured physical function, by their ``sizes``, by default
    as they are now; half-spaces stay such. Returns their number."""
    presets = {obj: material for obj in objects if (material := preset_of(obj)) is not None}
    sizes = sizes or Sizes(presets)
    for obj, material in presets.items():
        _damp(obj, material, sizes, in_a_building)
    return len(presets)


def _damp(
    obj: Object, material: Material | None, sizes: Sizes, in_a_building: bool = False
) -> None:
    """Set the properties of an object by the measured damping of its material; an unknown material
    damps like plastic, with the transfer coefficient that follows from the object's own κ and ρ.
    Values that are equal already are not written, because a write takes longer than a
    comparison."""
    haptics = obj.haptics
    is_half_space = (haptics.function, haptics.wave) == ("physical", "surface")
    name = "plastic" if material is None else material.name
    part = part_in(obj.name) if name == "flesh" else ""
    size = sizes.of(obj)
    values = _damping(name, size.edges, in_a_building, part, is_half_space, size.volume)
    haptics.function = "resilient" if name in SPRINGS else "physical"
    if material is None:
        values = {**values, "material_k": transfer_coefficient(haptics.kappa, haptics.rho)}
    for key, value in values.items():
        if getattr(haptics, key) != value:
            setattr(haptics, key, value)


@lru_cache(maxsize=1024)
def _damping(*told: Any) -> Mapping[str, Any]:
    """What the properties of an object hold of the function of a body."""
    return MappingProxyType(held_values(HapticObjectProperties, function_of(*told)))


def use_paper(objects: Iterable[Object]) -> int:
    """Give objects made of presets the paper's function. Returns the number of objects."""
    made = [obj for obj in objects if preset_of(obj) is not None]
    for obj in made:
        obj.haptics.function = "haptic_tracing"
    return len(made)


def set_bodies(objects: Iterable[Object], body: str) -> int:
    """Let those of ``objects`` that are made of flesh damp as measured, or be felt all over.
    Returns their number."""
    bodies = [obj for obj in objects if preset_of(obj) is _FLESH]
    sizes = Sizes(bodies)
    for obj in bodies:
        _damp(obj, _FLESH, sizes)
        if body == "FELT_ALL_OVER":
            write_values(obj.haptics, felt_all_over(sizes.of(obj).edges))
    return len(bodies)


def targets(context: Context, target: str) -> list[Object]:
    """The editable objects with a surface among the "selected" ones, their "children" or those of
    the "collection"."""
    match target:
        case "CHILDREN":
            found = {
                child
                for obj in context.selected_objects
                for child in (obj, *obj.children_recursive)
            }
            objects: Iterable[Object] = (obj for obj in context.view_layer.objects if obj in found)
        case "COLLECTION":
            objects = (
                context.object.users_collection[0].all_objects
                if context.object and context.object.users_collection
                else ()
            )
        case _:
            objects = context.selected_objects
    return list(objects)


def guesses(objects: Sequence[Object]) -> dict[Object, Material | None]:
    """The probable material of each object, by the names of its surfaces, of itself, of its mesh
    and its collections, its shape and its mass; None where nothing tells."""
    collections: dict[Object, list[Collection]] = {obj: [] for obj in objects}
    scenes = (scene.collection for scene in bpy.data.scenes)
    for collection in (*bpy.data.collections, *scenes):
        for obj in collection.objects:
            if obj in collections:
                collections[obj].append(collection)
    with_robots = lru_cache(_holds_robot)
    found = {}
    for obj in progress(objects):
        holders = collections[obj]
        material = _guess(obj, [holder.name for holder in holders])
        if material is _FLESH and (_hangs_on_robot(obj) or any(map(with_robots, holders))):
            material = guess((), *_size_and_mass(obj))
        found[obj] = material
    return found


def _guess(obj: Object, collections: Sequence[str]) -> Material | None:
    names = [*_surfaces(obj), obj.name] + ([obj.data.name] if obj.data is not None else [])
    names += collections
    rows = bpy.context.scene.haptics.materials.names
    told = [rows[name].preset for name in names if name in rows]
    known = next((MATERIALS[preset] for preset in told if preset in MATERIALS), None)
    return known or guess(names, *_size_and_mass(obj))


def _size_and_mass(obj: Object) -> tuple[tuple[float, float, float], float | None]:
    """Size [m] of an object and its mass [kg], None if that was not set."""
    body, scene = obj.rigid_body, bpy.context.scene
    is_weighed = body is not None and body.mass != 1.0  # 1 is Blender's default
    x, y, z = obj.dimensions * metres_per_unit(scene)
    return (x, y, z), mass_of(obj, scene) if is_weighed else None


def _surfaces(obj: Object) -> list[str]:
    """The names of an object's Blender materials."""
    return [slot.material.name for slot in obj.material_slots if slot.material is not None]


def names_of_surfaces(objects: Iterable[Object]) -> list[str]:
    """The names that tell what objects are made of: those of Blender materials, of objects without
    any their own."""
    return sorted({name for obj in objects for name in _surfaces(obj) or [obj.name]})


def list_names(scene: Scene, objects: Iterable[Object]) -> None:
    """Add the names of `names_of_surfaces` to the scene's table, with what they seem to stand
    for."""
    rows = scene.haptics.materials.names
    for name in names_of_surfaces(objects):
        if name not in rows:
            row = rows.add()
            material = guess([name])
            row.name = name
            row.preset = "NONE" if material is None else material.name


def _hangs_on_robot(obj: Object) -> bool:
    """Whether an object or what it hangs on is called as parts of robots are in files for
    simulators: link, joint, gripper."""
    above: Object | None = obj
    while above is not None:
        if _OF_ROBOTS.search(above.name):
            return True
        above = above.parent
    return False


def _holds_robot(collection: Collection) -> bool:
    """Whether a collection or half of its objects are called as robots or their parts."""
    parts = sum(_OF_ROBOTS.search(obj.name) is not None for obj in collection.objects)
    return _OF_ROBOTS.search(collection.name) is not None or 2 * parts >= len(collection.objects)


def apply_guesses(scene: Scene, objects: Sequence[Object]) -> int:
    """Assign the guessed materials to objects. Returns how many could be guessed."""
    known = guesses(objects)
    _apply_presets(scene, known, Sizes(objects))
    return sum(material is not None for material in known.values())


def _apply_presets(scene: Scene, made_of: Mapping[Object, Material | None], sizes: Sizes) -> None:
    """Assign presets to objects, those of one preset at once."""
    for material in dict.fromkeys(made_of.values()):
        if material is not None:
            objects = [obj for obj, own in made_of.items() if own is material]
            apply(objects, preset_in(scene, material), sizes)
