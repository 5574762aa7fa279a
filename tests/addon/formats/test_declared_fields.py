"""A field of a scene value is declared once: its property, its schema, its check, its reading and
writing follow."""

import json
from dataclasses import dataclass, replace

import bpy
import jsonschema
import numpy as np
import pytest
from haptic_tracing.addon.io.property_writer import stored_text
from haptic_tracing.addon.panels.drawing import draw_held
from haptic_tracing.addon.properties.callbacks import Stored, updating
from haptic_tracing.addon.properties.declared import holding, read_values, write_values
from haptic_tracing.addon.scene_reader import digest
from haptic_tracing.addon.scene_reader.imported import stored_item
from haptic_tracing.core.declaration import (
    Choice,
    Curve,
    Number,
    Numbers,
    Switch,
    Text,
    choice,
    declared,
    default_of,
    number,
    shown,
)
from haptic_tracing.core.formats.haptic_scene import read_export
from haptic_tracing.core.formats.io import scene_schema, schema
from haptic_tracing.core.formats.io.error import FormatError
from haptic_tracing.core.formats.io.schema import load_schema
from haptic_tracing.core.formats.scene.values_json import item_to_dict, read_value
from haptic_tracing.core.scene.functions import FUNCTIONS, TRANSMISSIONS
from haptic_tracing.core.scene.impact_rule import ImpactLimits, ImpactRule
from haptic_tracing.core.scene.library import LibraryMaterial
from haptic_tracing.core.scene.rules import ContactSettings
from haptic_tracing.core.scene.texture import Texture
from haptic_tracing.core.scene.values import HapticObject, Listener, Settings, Source
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from program import run
from scene_files import exported, imported

FEW = settings(
    max_examples=20, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck)
)
PLAIN = {
    "format": "haptic-scene",
    "version": "1.1",
    "settings": {},
    "rules": {
        "impact_table": [{"limits": {"refractory": 0.2}}],
        "transmission_table": [{"transmission": {"function": "resilient"}}],
        "textures": [{"between": [{"material": "steel"}]}],
    },
    "objects": [
        {"name": "floor", "kappa": 0.1, "rho": 0.9, "shape": {"type": "box", "size": [2, 2, 0.1]}}
    ],
    "sources": [{"name": "drill", "object": "floor", "position": [0.5, 0, 0.05]}],
    "listeners": [{"name": "seat", "object": "floor", "position": [0, 0, 0.05]}],
    "materials": [{"name": "steel", "kappa": 0.1, "rho": 0.9}],
}
PLACES = {
    Settings: (("settings",), lambda: bpy.context.scene.haptics),
    ContactSettings: (("rules",), lambda: bpy.context.scene.haptics),
    ImpactRule: (
        ("rules", "impact_table", 0),
        lambda: bpy.context.scene.haptics.impact_table.items[0],
    ),
    ImpactLimits: (
        ("rules", "impact_table", 0, "limits"),
        lambda: bpy.context.scene.haptics.impact_table.items[0],
    ),
    Texture: (("rules", "textures", 0), lambda: bpy.context.scene.haptics.textures.items[0]),
    HapticObject: (("objects", 0), lambda: bpy.data.objects["floor"].haptics),
    Source: (("sources", 0), lambda: bpy.data.objects["drill"].haptics.source),
    Listener: (("listeners", 0), lambda: bpy.data.objects["seat"].haptics.listener),
    LibraryMaterial: (("materials", 0), lambda: bpy.context.scene.haptics.materials.items["steel"]),
    **{
        cls: (("objects", 0, "propagation"), lambda: bpy.data.objects["floor"].haptics)
        for cls in FUNCTIONS.values()
    },
    **{
        cls: (
            ("rules", "transmission_table", 0, "transmission"),
            lambda: bpy.context.scene.haptics.transmission_table.items[0],
        )
        for name, cls in TRANSMISSIONS.items()
        if name not in FUNCTIONS
    },
}
"""By class, where an item of it is in a file, and the properties that hold it."""
DECLARED = [cls for cls in PLACES if shown(cls)]


def there_and_back(document, folder):
    """The document that Blender writes after it has read one."""
    (folder / "a.json").write_text(json.dumps(document))
    imported(folder / "a.json")
    return json.loads(exported(folder / "b.json"))


def at(document, place):
    for key in place:
        document = document[key]
    return document


@pytest.mark.parametrize("cls", DECLARED, ids=lambda cls: cls.__name__)
def test_properties_have_the_range_the_words_and_the_choices_of_their_fields(tmp_path, cls):
    there_and_back(PLAIN, tmp_path)
    owner = PLACES[cls][1]()
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


def values_of(field, default):
    """Values of a field as files may have them: its limits, and numbers with all digits."""
    match field:
        case Numbers():
            return st.lists(
                st.sampled_from([field.low, field.high])
                | st.floats(field.low, min(field.high, 10)),
                min_size=field.count,
                max_size=field.count,
            )
        case Number(whole=True):
            return st.sampled_from([int(field.low), int(field.high)]) | st.integers(
                int(field.low), int(field.high)
            )
        case Number():
            low = 1e-30 if field.above else field.low  # whose reciprocal is a number
            return (
                st.sampled_from([low, field.high])
                | st.floats(low, field.high)
                | st.floats(low, min(field.high, 10))
            )
        case Switch():
            return st.booleans()
        case Choice():
            return st.sampled_from(list(map(str, field.items)))
        case Curve():
            numbers = st.floats(1e-3, 1e5)
            return st.dictionaries(numbers, numbers, max_size=4).map(
                lambda points: [list(point) for point in sorted(points.items())]
            )
        case Text():
            return st.just(default)
    raise AssertionError(field)


@st.composite
def items(draw, cls):
    """The declared values of an item as a file has them."""
    item = {
        field.key or key: draw(values_of(field, default_of(cls, key)))
        for key, field in shown(cls).items()
    }
    if item.get("mixing") == "custom":
        item["mixing_expression"] = "0.5 * sum"
    return item


def written_form(value):
    return json.loads(json.dumps(value))


@pytest.mark.slow
@pytest.mark.parametrize("cls", DECLARED, ids=lambda cls: cls.__name__)
def test_what_is_untouched_comes_back_as_written(tmp_path_factory, cls):
    folder, place = tmp_path_factory.mktemp(cls.__name__), PLACES[cls][0]

    @FEW
    @given(item=items(cls))
    def check(item):
        document = written_form(PLAIN)
        form = at(document, place[:-1])
        form[place[-1]] = {
            **(form[place[-1]] if place[-1] in form or isinstance(place[-1], int) else {}),
            **item,
        }
        if place[-1] in ("propagation", "transmission"):
            form[place[-1]]["function"] = cls.name
        found = at(there_and_back(document, folder), place)
        defaults = {field.key or key: default_of(cls, key) for key, field in shown(cls).items()}
        assert {
            key: found[key] if key in found else written_form(defaults[key]) for key in item
        } == item
        core = read_export(folder / "a.json").scene
        assert core.listeners == read_export(folder / "b.json").scene.listeners

    check()


def test_a_listener_with_more_digits_than_blender_has_is_imported_and_plays(tmp_path, traced):
    document = written_form(PLAIN)
    document["listeners"][0]["ducking"] = 12.345678912
    assert there_and_back(document, tmp_path)["listeners"][0]["ducking"] == 12.345678912
    (listener,) = traced().listeners
    assert listener.ducking == 12.345678912 and traced().amplitudes.max() > 0


def test_large_numbers_are_the_same_in_a_file_on_the_command_line_and_in_blender(tmp_path, traced):
    document = written_form(PLAIN)
    burst = {"signal": {"signal": "decaying_sine", "frequency": 100, "decay": 0.1}, "onset": 2e6}
    document["sources"] = [
        {**document["sources"][0], "priority": 1e7},
        {**document["sources"][0], "name": "late", **burst},
    ]
    document["listeners"][0] |= {"gain": 1e7, "mixing": "weighted"}
    jsonschema.Draft202012Validator(load_schema("haptic-scene-1.1")).validate(document)
    written = there_and_back(document, tmp_path)
    assert (
        written["sources"][0]["priority"] == written["listeners"][0]["gain"] == 1e7
        and written["sources"][1]["onset"] == 2e6
    )
    assert traced().gains[0, 0] > 0 and traced().listeners[0].gain == 1e7
    bpy.data.objects["drill"].haptics.source.priority = 1e9
    assert traced().gains[0, 0] > 0 and traced().sources[0].priority == 1e9
    done = run("export", tmp_path / "a.json", "--to", "wav", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "a.wav").is_file()


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
        holding(_Listener)(type("HapticListenerOfTest", (Stored, bpy.types.PropertyGroup), {}))
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
        **written_form(PLAIN),
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
    group.imported = stored_text(item)
    assert (
        read_values(_Listener, group, stored_item(group.imported, "listener"))["stiffness"]
        == 1.23456789
    )
    group.stiffness = 2.0
    assert (
        read_values(_Listener, group, stored_item(group.imported, "listener"))["stiffness"] == 2.0
    )
    layout = recording_layout()
    draw_held(layout, group, _Listener)
    assert layout.properties == list(shown(_Listener)) and {"stiffness", "side"} <= set(
        layout.properties
    )
    schema._validator.cache_clear()


def test_what_version_0_1_stored_counts_as_it_did(tmp_path):
    """It stored only what properties could not hold, and numbers apart from the rest."""
    there_and_back(PLAIN, tmp_path)
    scene, floor = bpy.context.scene.haptics, bpy.data.objects["floor"].haptics
    seat, drill = (
        bpy.data.objects["seat"].haptics.listener,
        bpy.data.objects["drill"].haptics.source,
    )
    rule, texture = scene.impact_table.items[0], scene.textures.items[0]
    digits = 0.1234567890123
    for owner, name in (
        (scene, "threshold"),
        (scene, "contact_tolerance"),
        (floor, "kappa"),
        (seat, "radius"),
        (drill, "amplitude"),
    ):
        setattr(owner, name, digits)
    floor.function, floor.alpha, rule.bend, texture.period = "exponential", digits, digits, digits
    floor.imported = json.dumps(
        {
            "numbers": {"kappa": digits},
            "function": {"function": "exponential", "alpha": digits},
            "mass": 2.5,
            "extras": {"a": 1},
        }
    )
    seat.imported = json.dumps(
        {"position": [0, 0, 0.05], "numbers": {"radius": digits}, "extras": {"b": 2}}
    )
    drill.imported = json.dumps(
        {
            "numbers": {"amplitude": digits},
            "signal": {"signal": "sine", "frequency": 70.5},
            "onset": 3,
        }
    )
    drill.signal = "KEPT"
    numbers = {"threshold": digits, "contact_tolerance": digits}
    scene.imported = json.dumps(
        {"numbers": numbers, "tolerance": 0.5, "slack": 0.25, "extras": {"c": 3}}
    )
    signal = {"signal": "decaying_sine", "frequency": 90.5, "decay": 0.25, "amplitude": 1.0}
    rule.template, rule.use_limits, rule.refractory = "KEPT", True, digits
    rule.imported = json.dumps(
        {"numbers": {"bend": digits, "refractory": digits}, "signal": signal}
    )
    texture.imported = json.dumps({"numbers": {"period": digits}})
    written = json.loads(exported(tmp_path / "c.json"))
    settings, rules, item = written["settings"], written["rules"], written["objects"][0]
    assert (
        settings["threshold"]
        == rules["tolerance"]
        == item["kappa"]
        == item["propagation"]["alpha"]
        == digits
    )
    assert (settings["tolerance"], rules["slack"], item["mass"], item["extras"]) == (
        0.5,
        0.25,
        2.5,
        {"a": 1},
    )
    assert written["listeners"][0]["radius"] == written["sources"][0]["amplitude"] == digits
    assert (
        written["listeners"][0]["extras"],
        written["extras"]["c"],
        written["sources"][0]["onset"],
    ) == ({"b": 2}, 3, 3.0)
    assert written["sources"][0]["signal"]["frequency"] == 70.5
    (impact,), (rough,) = rules["impact_table"], rules["textures"]
    assert (
        impact["bend"] == impact["limits"]["refractory"] == rough["period"] == digits
        and impact["template"] == signal
    )
