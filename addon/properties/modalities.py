"""The properties of every modality, generated from its definition: those of objects, of sources and
of the scene."""

from __future__ import annotations

from typing import Any

from bpy.props import PointerProperty
from bpy.types import PropertyGroup

from ...core.declaration import shown
from ...core.modalities import MODALITIES, Modality
from .callbacks import changed, updating
from .declared import holding
from .function import FunctionParameters, function_property
from .kinds import switch


def _group(
    name: str, annotations: dict[str, Any], words: str, *mixins: type
) -> type[PropertyGroup]:
    return type(
        name,
        (*mixins, PropertyGroup),
        {"__annotations__": annotations, "__doc__": words, "__module__": __name__},
    )


def _object_group(modality: Modality) -> type[PropertyGroup]:
    """The properties of an object, and of a source, for a modality."""
    annotations = {
        "function": function_property(tuple(modality.functions), modality.default_function),
        "is_source": switch("Source", "This object emits it"),
    }
    group = _group(
        f"Haptic{modality.name.title()}Object",
        annotations,
        modality.description,
        FunctionParameters,
    )
    named: dict[str, Any] = dict.fromkeys(shown(modality.source), "source_value")
    return updating()(holding(modality.source, **named)(holding(modality.values)(group)))


def _scene_group(modality: Modality) -> type[PropertyGroup]:
    enabled = switch(modality.title, modality.description, update=changed)
    return _group(f"Haptic{modality.name.title()}Scene", {"enabled": enabled}, modality.description)


def _container(name: str, groups: dict[str, type[PropertyGroup]]) -> type[PropertyGroup]:
    return _group(
        name,
        {key: PointerProperty(type=group) for key, group in groups.items()},
        "One group per modality.",
    )


_OBJECT_GROUPS = {name: _object_group(modality) for name, modality in MODALITIES.items()}
_SCENE_GROUPS = {name: _scene_group(modality) for name, modality in MODALITIES.items()}
HapticObjectModalities = _container("HapticObjectModalities", _OBJECT_GROUPS)
HapticSceneModalities = _container("HapticSceneModalities", _SCENE_GROUPS)

GROUPS = (
    *_OBJECT_GROUPS.values(),
    *_SCENE_GROUPS.values(),
    HapticObjectModalities,
    HapticSceneModalities,
)
