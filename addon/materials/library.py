"""Materials put into a scene's library, and objects made of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bpy.types import Context, Object, Scene

from ...core.materials import MATERIALS, Material, guess
from ..progress import progress
from .properties import HapticMaterial, holders, unique_name, values_of, write_values

SOUND_ABSORPTION = 0.05
"""From this attenuation per metre of the highest band on, a material's bands are worth their cost."""


def preset_values(material: Material) -> dict[str, object]:
    """The values of a preset as a library holds them."""
    return {
        "kappa": material.kappa,
        "rho": material.rho,
        "wave_speed": material.wave_speed,
        "use_bands": max(material.band_decays) >= SOUND_ABSORPTION,
        "band_decays": material.band_decays,
        "conductivity": material.conductivity,
    }


def add(scene: Scene, name: str, values: dict[str, object]) -> HapticMaterial:
    """A new material of the scene's library, which gets a number where its name is taken."""
    library = scene.haptics.materials
    name = unique_name(name, {item.name for item in library.items})
    item = library.items.add()
    item.known_as = name
    item.name = name
    for key, value in values.items():
        setattr(item, key, value)
    library.active = len(library.items) - 1
    return item


def preset_in(scene: Scene, material: Material) -> HapticMaterial:
    """The material of the scene's library that carries the preset's title; it is put there where there is none."""
    return scene.haptics.materials.items.get(material.title) or add(scene, material.title, preset_values(material))


def apply(objects: Sequence[Object], item: HapticMaterial) -> None:
    """Make objects of a material: they take its values, now and when it changes."""
    name, values = item.name, values_of(item)
    for obj in progress(objects):
        write_values(obj, values)
        if obj.haptics.material.name != name:
            obj.haptics.material.name = name


def own_values(obj: Object) -> dict[str, object]:
    """The values that an object has itself."""
    return {name: tuple(value) if name == "band_decays" else value for name, holder in holders(obj).items() for value in (getattr(holder, name),)}


def targets(context: Context, target: str) -> list[Object]:
    """What "selected", "children" or "collection" means now: objects that vibration can pass through and that can be edited."""
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
    """The material that an object is probably made of: by the names of its surfaces, its own and its mesh's, its shape and its mass."""
    names = [slot.material.name for slot in obj.material_slots if slot.material is not None]
    names += [obj.name] + ([obj.data.name] if obj.data is not None else [])
    body = obj.rigid_body
    mass = body.mass if body is not None and body.mass != 1.0 else None  # 1 kg is what nobody has set
    return guess(names, tuple(obj.dimensions), mass)


def find(name: str) -> Material:
    """A preset by name. Raises ValueError that lists the known names."""
    if name not in MATERIALS:
        raise ValueError(f"material {name!r} is unknown: use one of {', '.join(MATERIALS)}")
    return MATERIALS[name]
