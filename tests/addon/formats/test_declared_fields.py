"""A field of a scene value is declared once: its property, its schema, its check, its reading and
writing follow."""

from dataclasses import dataclass, replace

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.panels.drawing import draw_held
from haptic_tracing.addon.properties.callbacks import updating
from haptic_tracing.addon.properties.declared import holding, read_values, write_values
from haptic_tracing.addon.scene_reader import digest
from haptic_tracing.core.declaration import (
    Choice,
    Number,
    choice,
    declared,
    number,
    shown,
)
from haptic_tracing.core.formats.io import scene_schema, schema
from haptic_tracing.core.formats.io.error import FormatError
from haptic_tracing.core.formats.io.schema import load_schema
from haptic_tracing.core.formats.scene.values_json import item_to_dict, read_value
from haptic_tracing.core.scene.functions import FUNCTIONS, TRANSMISSIONS
from haptic_tracing.core.scene.impact_rule import ImpactRule
from haptic_tracing.core.scene.library import LibraryMaterial
from haptic_tracing.core.scene.rules import ContactSettings
from haptic_tracing.core.scene.texture import Texture
from haptic_tracing.core.scene.values import HapticObject, Listener, Settings, Source

OWNERS = {
    Settings: lambda: bpy.context.scene.haptics,
    ContactSettings: lambda: bpy.context.scene.haptics,
    ImpactRule: lambda: bpy.context.scene.haptics.impact_table.items.add(),
    Texture: lambda: bpy.context.scene.haptics.textures.items.add(),
    HapticObject: lambda: bpy.data.objects.new("floor", None).haptics,
    Source: lambda: bpy.data.objects.new("drill", None).haptics.source,
    Listener: lambda: bpy.data.objects.new("seat", None).haptics.listener,
    LibraryMaterial: lambda: bpy.context.scene.haptics.materials.items.add(),
    **{cls: lambda: bpy.data.objects.new("floor", None).haptics for cls in FUNCTIONS.values()},
    **{
        cls: lambda: bpy.context.scene.haptics.transmission_table.items.add()
        for name, cls in TRANSMISSIONS.items()
        if name not in FUNCTIONS
    },
}
"""By class, properties that hold an item of it."""
DECLARED = [cls for cls in OWNERS if shown(cls)]


@pytest.mark.parametrize("cls", DECLARED, ids=lambda cls: cls.__name__)
def test_properties_have_the_range_the_words_and_the_choices_of_their_fields(cls):
    owner = OWNERS[cls]()
    assert owner.held[cls].keys() == shown(cls).keys()
    for key, name in owner.held[cls].items():
        found, field = owner.bl_rna.properties[name], declared(cls)[key]
        assert found.description == field.about and found.name.startswith(
            field.label.removesuffix(")")
        )
        match field:
            case Number():
                most = np.float32(field.high)
                assert found.hard_max == most if not field.whole else found.hard_max == field.high
                assert found.hard_min == np.float32(field.low) or (
                    field.above and 0 < found.hard_min < 1e-30
                )
                if field.soft:
                    assert found.soft_max == np.float32(field.soft[1])
            case Choice():
                assert [item.name for item in found.enum_items] == [
                    label for label, _ in field.items.values()
                ]


@dataclass(frozen=True, slots=True)
class _Listener(Listener):
    """A listener with two fields more than this version has."""

    stiffness: float = number(
        0.5, "Skin", "How stiff the skin is", 0.0, 10.0, soft=(0.0, 2.0), unit="N/m"
    )
    side: str = choice(
        "left", "Side", "Where it is", {"left": ("Left", "At home"), "right": ("Right", "Away")}
    )


@pytest.fixture
def group():
    """A property group that holds such a listener, as an object's property."""
    cls = updating()(
        holding(_Listener)(type("HapticListenerOfTest", (bpy.types.PropertyGroup,), {}))
    )
    bpy.utils.register_class(cls)
    bpy.types.Object.listener_of_test = bpy.props.PointerProperty(type=cls)
    yield bpy.data.objects.new("test", None).listener_of_test
    del bpy.types.Object.listener_of_test
    bpy.utils.unregister_class(cls)


def test_a_new_field_arrives_everywhere(monkeypatch, group, recording_layout):
    monkeypatch.setitem(scene_schema.DEFINED, "listener", _Listener)
    schema._validator.cache_clear()
    document = {
        "format": "haptic-scene",
        "version": "1.1",
        "objects": [{"name": "floor", "kappa": 0.1, "rho": 0.9}],
        "listeners": [
            {"name": "seat", "object": "floor", "position": [0, 0, 0], "stiffness": 1.23456789}
        ],
    }
    schema.validate(document, "haptic-scene-1.1", "a.json")
    found = load_schema("haptic-scene-1.1")["$defs"]["listener"]["properties"]
    assert (found["stiffness"]["minimum"], found["stiffness"]["maximum"]) == (0.0, 10.0) and found[
        "side"
    ]["enum"] == ["left", "right"]
    assert found["stiffness"]["description"] == "How stiff the skin is. Unit: N/m. Default: 0.5."
    with pytest.raises(FormatError, match="/listeners/0/stiffness: must be at most 10, got 11"):
        schema.validate(
            {**document, "listeners": [{**document["listeners"][0], "stiffness": 11}]},
            "haptic-scene-1.1",
            "a.json",
        )
    item = read_value(_Listener, document["listeners"][0], ("listeners", 0))
    assert item.stiffness == 1.23456789 and item_to_dict(item) == document["listeners"][0]
    with pytest.raises(ValueError, match=r"stiffness: must be from 0 to 10 N/m, got 10\.5"):
        replace(item, stiffness=10.5)
    assert group.bl_rna.properties["stiffness"].name == "Skin (N/m)" and group.side == "left"
    before = digest._values(group, (), "")
    assert write_values(group, item) == []
    assert digest._values(group, (), "") != before
    assert read_values(_Listener, group)["stiffness"] == pytest.approx(1.23456789, rel=1e-7)
    layout = recording_layout()
    draw_held(layout, group, _Listener)
    assert layout.properties == list(shown(_Listener)) and {"stiffness", "side"} <= set(
        layout.properties
    )
    schema._validator.cache_clear()
