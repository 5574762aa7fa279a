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


def _group(name: str, words: str, *mixins: type, **annotations: Any) -> type[PropertyGroup]:
    return type(
        f"Haptic{name}",
        (*mixins, PropertyGroup),
        {"__annotations__": annotations, "__doc__": words, "__module__": __name__},
    )


def _object_group(modality: Modality) -> type[PropertyGroup]:
    """The properties of an object, and of a source, for a modality."""
    group = _group(
        f"{modality.name.title()}Object",
        modality.description,
        FunctionParameters,
        function=function_property(tuple(modality.functions), modality.default_function),
        is_source=switch("Source", "This object emits it"),
    )
    named: dict[str, Any] = dict.fromkeys(shown(modality.source), "source_value")
    return updating()(holding(modality.source, **named)(holding(modality.values)(group)))


def _container(name: str, groups: dict[str, type[PropertyGroup]]) -> type[PropertyGroup]:
    pointers = {key: PointerProperty(type=group) for key, group in groups.items()}
    return _group(name, "One group per modality.", **pointers)


_OBJECT_GROUPS = {name: _object_group(modality) for name, modality in MODALITIES.items()}
_SCENE_GROUPS = {
    name: _group(
        f"{name.title()}Scene",
        modality.description,
        enabled=switch(modality.title, modality.description, update=changed),
    )
    for name, modality in MODALITIES.items()
}
HapticObjectModalities = _container("ObjectModalities", _OBJECT_GROUPS)
HapticSceneModalities = _container("SceneModalities", _SCENE_GROUPS)

GROUPS = (
    *_OBJECT_GROUPS.values(),
    *_SCENE_GROUPS.values(),
    HapticObjectModalities,
    HapticSceneModalities,
)
