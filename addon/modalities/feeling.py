"""What the modalities beside vibration give at the listeners of a traced frame, through the same contacts."""

from __future__ import annotations

from typing import Any

from bpy.types import Object, Scene

from ...core.frame_result import FrameResult
from ...core.modalities import Emitter, Felt, Modality, feel
from ..function_properties import PARAMETERS
from ..scene_reader import Problem, haptic_carrier, read_settings
from .properties import SHOWN

_felt: dict[int, tuple[Felt, ...]] = {}


def felt_in(scene: Scene) -> tuple[Felt, ...]:
    """What the last traced frame of a scene felt like, one value per modality that is switched on."""
    return _felt.get(scene.session_uid, ())


def forget() -> None:
    """Forget all frames."""
    _felt.clear()


def wanted_in(scene: Scene) -> list[Modality]:
    """The modalities beside vibration that a scene has switched on: they need all contacts, wherever vibration gets to."""
    return [modality for modality in SHOWN if getattr(scene.haptics.modalities, modality.name).enabled]


def trace(scene: Scene, result: FrameResult | None) -> tuple[Problem, ...]:
    """Propagate the modalities that the scene has switched on, and keep what they give. Returns what a designer should mend."""
    _felt.pop(scene.session_uid, None)
    wanted = wanted_in(scene)
    if result is None or not wanted:
        return ()
    objects = {obj.name_full: obj for obj in scene.objects}
    found: list[Felt] = []
    problems: list[Problem] = []
    for modality in wanted:
        try:
            found.append(_feel(modality, objects, result, scene))
        except ValueError as error:
            problems.append(Problem("", f"{modality.title}: {error}"))
    _felt[scene.session_uid] = tuple(found)
    return tuple(problems)


def _feel(modality: Modality, objects: dict[str, Object], result: FrameResult, scene: Scene) -> Felt:
    groups = {name: getattr(objects[name].haptics.modalities, modality.name) for name in result.objects if name in objects}
    return feel(
        modality,
        result.objects,
        {name: {quantity.name: getattr(group, quantity.name) for quantity in modality.object_values} for name, group in groups.items()},
        result.contacts,
        [emitter for obj in objects.values() if (emitter := _emitter(modality, obj, groups)) is not None],
        result.listeners,
        read_settings(scene),
        {name: _form(group) for name, group in groups.items() if group.function != modality.default_function},
    )


def _form(group: Any) -> dict[str, Any]:
    parameters = {key: getattr(group, name) for key, name in PARAMETERS.get(group.function, {}).items()}
    return {"function": group.function, **parameters}


def _emitter(modality: Modality, obj: Object, groups: dict[str, Any]) -> Emitter | None:
    """The object as a source, where it is one that stands on a traced object."""
    group = getattr(obj.haptics.modalities, modality.name)
    if not group.is_source:
        return None
    carrier = haptic_carrier(obj)
    if carrier is None or carrier.name_full not in groups:
        return None
    return Emitter(obj.name_full, carrier.name_full, tuple(obj.matrix_world.translation), group.source_value)
