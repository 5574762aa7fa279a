"""What the modalities beside vibration give at the listeners of a traced frame, through the same contacts."""

from __future__ import annotations

from bpy.types import Scene

from ...core.modalities import Felt, Modality, feel
from ...core.render.frame_result import FrameResult
from ..properties.modalities import SHOWN
from ..scene_reader.modalities import read_modality
from ..scene_reader.reader import Problem, read_settings

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
    found: list[Felt] = []
    problems: list[Problem] = []
    for modality in wanted:
        try:
            found.append(_feel(modality, result, scene))
        except ValueError as error:
            problems.append(Problem("", f"{modality.title}: {error}"))
    _felt[scene.session_uid] = tuple(found)
    return tuple(problems)


def _feel(modality: Modality, result: FrameResult, scene: Scene) -> Felt:
    own = read_modality(modality, scene, set(result.objects))
    return feel(modality, result.objects, own.values, result.contacts, own.emitters, result.listeners, read_settings(scene), own.forms)
