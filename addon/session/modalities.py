"""Modalities other than vibration at the listeners of a traced frame, through the same contacts."""

from __future__ import annotations

from collections.abc import Sequence

from bpy.types import Scene

from ...core.modalities import Modality
from ...core.modalities.propagation import Felt, ModalityScene, feel
from ...core.render.frame_result import FrameResult
from ...core.scene.values import HapticObject, Settings
from ..properties.modalities import SHOWN
from ..scene_reader.modalities import read_modality


def wanted_in(scene: Scene) -> list[Modality]:
    """The enabled modalities other than vibration. They need all contacts, including those without vibration."""
    return [modality for modality in SHOWN if getattr(scene.haptics.modalities, modality.name).enabled]


def read(scene: Scene, objects: Sequence[HapticObject]) -> tuple[tuple[ModalityScene, ...], tuple[str, ...]]:
    """The values of the haptic ``objects`` for the enabled modalities, and their problems."""
    found, errors = [], []
    for modality in wanted_in(scene):
        try:
            found.append(read_modality(modality, scene, {item.name for item in objects}))
        except ValueError as error:
            errors.append(f"{modality.title}: {error}")
    return tuple(found), tuple(errors)


def felt_of(readings: Sequence[ModalityScene], result: FrameResult, settings: Settings) -> tuple[tuple[Felt, ...], tuple[str, ...]]:
    """The values of each modality at the listeners of a frame, and errors. Does not access Blender."""
    felt, errors = [], []
    for own in readings:
        try:
            felt.append(
                feel(own.modality, result.objects, own.values, result.contacts, own.emitters, result.listeners, settings, own.forms)
            )
        except ValueError as error:
            errors.append(f"{own.modality.title}: {error}")
    return tuple(felt), tuple(errors)
