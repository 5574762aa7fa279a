"""What the listeners of a traced frame feel of the modalities beside vibration, through the same contacts."""

from __future__ import annotations

from collections.abc import Sequence

from bpy.types import Scene

from ...core.modalities import Modality
from ...core.modalities.modality_scene import ModalityScene
from ...core.modalities.propagation import Felt, feel
from ...core.render.frame_result import FrameResult
from ...core.scene.values import HapticObject, Settings
from ..properties.modalities import SHOWN
from ..scene_reader.modalities import read_modality


def wanted_in(scene: Scene) -> list[Modality]:
    """The modalities beside vibration that a scene has switched on. They need all contacts, wherever vibration gets to."""
    return [modality for modality in SHOWN if getattr(scene.haptics.modalities, modality.name).enabled]


def read(scene: Scene, objects: Sequence[HapticObject]) -> tuple[tuple[ModalityScene, ...], tuple[str, ...]]:
    """What the haptic ``objects`` are like for the modalities that are switched on, and what is wrong with that."""
    found, errors = [], []
    for modality in wanted_in(scene):
        try:
            found.append(read_modality(modality, scene, {item.name for item in objects}))
        except ValueError as error:
            errors.append(f"{modality.title}: {error}")
    return tuple(found), tuple(errors)


def felt_of(readings: Sequence[ModalityScene], result: FrameResult, settings: Settings) -> tuple[tuple[Felt, ...], tuple[str, ...]]:
    """What the listeners of a frame feel of each modality, and what went wrong. Touches no Blender data."""
    felt, errors = [], []
    for own in readings:
        try:
            felt.append(
                feel(own.modality, result.objects, own.values, result.contacts, own.emitters, result.listeners, settings, own.forms)
            )
        except ValueError as error:
            errors.append(f"{own.modality.title}: {error}")
    return tuple(felt), tuple(errors)
