"""The properties of every modality without samples, generated from its definition: those of objects, of sources and of the scene."""

from __future__ import annotations

from typing import Any

from bpy.props import BoolProperty, FloatProperty, PointerProperty
from bpy.types import PropertyGroup

from ...core.modalities import MODALITIES, Modality, Quantity
from .callbacks import changed, updating
from .function import FunctionParameters, function_property
from .imported import drop

SHOWN: tuple[Modality, ...] = tuple(modality for modality in MODALITIES.values() if not modality.sampled)
"""The modalities other than vibration, which has its own properties and panels."""


def _property(quantity: Quantity) -> Any:
    """The property of a quantity."""
    unit = "" if quantity.unit in ("", "m") else quantity.unit
    return FloatProperty(
        name=f"{quantity.title} ({unit})" if unit else quantity.title,
        description=f"{quantity.description}, in {unit}" if unit else quantity.description,
        default=quantity.default,
        min=quantity.low,
        max=quantity.high,
        unit="LENGTH" if quantity.unit == "m" else "NONE",
    )


def _object_group(modality: Modality) -> type[PropertyGroup]:
    """The properties of an object, and of a source, for a modality."""
    annotations = {
        "function": function_property(tuple(modality.functions), modality.default_function),
        **{quantity.name: _property(quantity) for quantity in modality.object_values},
        "is_source": BoolProperty(name="Source", description="This object emits it", default=False),
        "source_value": _property(modality.source_value),
    }

    def drop_imported(self: PropertyGroup, name: str) -> None:
        drop(self.id_data.haptics, "numbers", f"{modality.name}.{name}")

    members = {"__annotations__": annotations, "__doc__": modality.description, "__module__": __name__, "drop_imported": drop_imported}
    return updating()(type(f"Haptic{modality.name.title()}Object", (FunctionParameters, PropertyGroup), members))


def _scene_group(modality: Modality) -> type[PropertyGroup]:
    enabled = BoolProperty(name=modality.title, description=modality.description, default=False, update=changed)
    return type(
        f"Haptic{modality.name.title()}Scene",
        (PropertyGroup,),
        {"__annotations__": {"enabled": enabled}, "__doc__": modality.description, "__module__": __name__},
    )


def _container(name: str, groups: dict[str, type[PropertyGroup]]) -> type[PropertyGroup]:
    annotations = {key: PointerProperty(type=group) for key, group in groups.items()}
    return type(name, (PropertyGroup,), {"__annotations__": annotations, "__doc__": "One group per modality.", "__module__": __name__})


_OBJECT_GROUPS = {modality.name: _object_group(modality) for modality in SHOWN}
_SCENE_GROUPS = {modality.name: _scene_group(modality) for modality in SHOWN}
HapticObjectModalities = _container("HapticObjectModalities", _OBJECT_GROUPS)
HapticSceneModalities = _container("HapticSceneModalities", _SCENE_GROUPS)

GROUPS = (*_OBJECT_GROUPS.values(), *_SCENE_GROUPS.values(), HapticObjectModalities, HapticSceneModalities)
