"""A Blender scene's values of a modality other than vibration, as values of the core."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from bpy.types import Object, Scene

from ...core.declaration import declared
from ...core.forms import JsonObject
from ...core.modalities import MODALITIES, Modality
from ...core.modalities.propagation import Emitter, ModalityScene
from ...core.scene.functions import ALL_FUNCTIONS
from ...core.scene.values import HapticObject, Vector
from ..blender.units import metres_per_unit
from ..properties.declared import read_values
from .imported import near, stored_modalities
from .roles import haptic_carrier


def read_modalities(
    scene: Scene, objects: Iterable[HapticObject]
) -> tuple[tuple[ModalityScene, ...], tuple[str, ...]]:
    """The values of the haptic ``objects`` for the enabled modalities, and their problems."""
    found = []
    errors = []
    for modality in MODALITIES.values():
        if getattr(scene.haptics.modalities, modality.name).enabled:
            try:
                found.append(read_modality(modality, scene, {item.name for item in objects}))
            except ValueError as error:
                errors.append(f"{modality.title}: {error}")
    return tuple(found), tuple(errors)


def read_modality(modality: Modality, scene: Scene, names: set[str]) -> ModalityScene:
    """The values of the haptic objects ``names`` of a scene. Raises ValueError if imported data is
    damaged."""
    values = {}
    forms = {}
    emitters = []
    prefix = f"{modality.name}."
    metres = metres_per_unit(scene)
    for obj in scene.objects:
        group = getattr(obj.haptics.modalities, modality.name)
        if obj.name_full not in names and not group.is_source:
            continue
        kept, homes = stored_modalities(obj.haptics.imported)
        numbers = {
            name.removeprefix(prefix): value
            for name, value in kept.items()
            if name.startswith(prefix)
        }
        if obj.name_full in names:
            own = _values(modality.values, group, numbers)
            values[obj.name_full] = {
                key: value for key, value in own.items() if value != modality.defaults()[key]
            }
            if group.function != modality.default_function:
                cls: type = ALL_FUNCTIONS[group.function]
                parameters = {
                    declared(cls)[key].key or key: value
                    for key, value in _values(cls, group, numbers).items()
                }
                forms[obj.name_full] = {"function": group.function, **parameters}
        emitter = _emitter(modality, obj, homes.get(modality.name), numbers, names, metres)
        if emitter is not None:
            emitters.append(emitter)
    return ModalityScene(
        modality=modality,
        values={name: own for name, own in values.items() if own},
        forms=forms,
        emitters=tuple(sorted(emitters, key=lambda emitter: emitter.name)),
        enabled=getattr(scene.haptics.modalities, modality.name).enabled,
    )


def _values(cls: type, group: Any, numbers: Mapping[str, float]) -> JsonObject:
    """The values of the fields of ``cls``; ``numbers``: those of a file by property."""
    known = {key: numbers[name] for key, name in group.held.get(cls, {}).items() if name in numbers}
    return read_values(cls, group, known)


def _emitter(
    modality: Modality,
    obj: Object,
    home: Vector | None,
    numbers: Mapping[str, float],
    names: set[str],
    metres: float,
) -> Emitter | None:
    """The object as a source of a modality.

    Args:
        modality: The modality.
        obj: The object.
        home: Its place in a file, None without one.
        numbers: Values of a file by property.
        names: Haptic objects that it may be on.
        metres: Per unit of Blender.

    Returns:
        The source; None if the object is not a source of this modality, or is on no such object.
    """
    group = getattr(obj.haptics.modalities, modality.name)
    carrier = haptic_carrier(obj) if group.is_source else None
    if carrier is None or carrier.name_full not in names:
        return None
    x, y, z = obj.matrix_world.translation * metres
    position = x, y, z
    position = home if home is not None and near(home, position) else position
    return Emitter(
        obj.name_full,
        carrier.name_full,
        position,
        *_values(modality.source, group, numbers).values(),
    )
