"""What listeners are felt through, in files."""

import json

import bpy
import numpy as np
import pytest
from haptic_tracing.core.devices.mapping import map_listeners
from haptic_tracing.core.devices.profile_files import profile
from haptic_tracing.core.formats.haptic_scene import read_export
from haptic_tracing.core.scene.device_mapping import DeviceMapping
from scene_files import exported


def device(name, **adjusted):
    settings = bpy.context.scene.haptics.live_output.devices.add()
    settings.name = name
    for key, value in adjusted.items():
        setattr(settings, key, value)


@pytest.fixture
def hands(add_box, add_empty):
    """A table with two hands and a back on it."""
    table = add_box("table", (0, 0, 0), (2, 1, 1))
    for name, part, x in (
        ("left", "hand.L", -0.4),
        ("right", "hand.R", 0.4),
        ("back", "upper_back.L", 0),
    ):
        place = add_empty(name, (x, 0, 0.5), parent=table)
        place.haptics.listener.enabled, place.haptics.listener.body_part = True, part
    bpy.context.view_layer.update()
    return bpy.data.objects


def test_automatic_choices_are_written_as_what_they_give(hands, tmp_path):
    device("dualsense AB:12")
    device("sound card Aura", gain=1.5, offset=-20.0)
    exported(tmp_path / "a.json")
    aura, pad = sorted(
        read_export(tmp_path / "a.json").devices, key=lambda item: item.profile != "sound card Aura"
    )
    assert aura == DeviceMapping(
        "sound card Aura", "sound card Aura", (), {"blender": {"gain": 1.5, "offset": -20.0}}
    )
    known = profile("dualsense")
    weights = map_listeners(
        {"left": "hand.L", "right": "hand.R", "back": "upper_back.L"}, {"pad": known}
    ).weights["pad"]
    expected = {
        (known.actuators[a].name, name)
        for i, name in enumerate(("left", "right", "back"))
        for a in weights[:, i].nonzero()[0]
    }
    assert pad.name == "dualsense AB:12" and pad.profile == "dualsense" and expected
    assert {(item.actuator, item.listener) for item in pad.actuators} == expected


def test_choices_of_the_user_are_written(hands, tmp_path):
    device("dualsense")
    hands["left"].haptics.live_output.actuators = "dualsense/right;bench/2"
    hands["right"].haptics.live_output.actuators = "-"
    document = json.loads(exported(tmp_path / "a.json"))
    bench, pad = document["devices"]
    assert bench == {
        "name": "bench",
        "profile": "bench",
        "actuators": [{"actuator": "2", "listener": "left", "gain": 1.0}],
    }
    assert pad["actuators"] == [{"actuator": "right", "listener": "left", "gain": 1.0}]
    exported(tmp_path / "c.json", frames="RANGE", frame_start=1, frame_end=2)
    assert json.loads((tmp_path / "c.json").read_text())["devices"] == document["devices"]


def test_a_muted_listener_is_written_as_muted_without_any_device(hands, tmp_path):
    hands["left"].haptics.live_output.actuators = "-"
    document = json.loads(exported(tmp_path / "a.json"))
    assert "devices" not in document
    muted = {
        item["name"] for item in document["listeners"] if item.get("extras") == {"muted": True}
    }
    assert muted == {"left"}


def test_gains_are_felt():
    """What the text of a choice says is what the samples are multiplied by."""
    from haptic_tracing.addon.properties.actuators import choice_of, places_of
    from haptic_tracing.core.devices.mapping import Place

    places = places_of(
        "dualsense AB:12/left grip*0.25;dualsense AB:12/right grip;odd/a*b*1.0;odd/a*b"
    )
    assert [(p.device, p.actuator, p.gain) for p in places] == [
        ("dualsense AB:12", "left grip", 0.25), ("dualsense AB:12", "right grip", 1.0), ("odd", "a*b", 1.0), ("odd", "a*b", 1.0),
    ]  # fmt: skip
    assert (
        choice_of(places[:3])
        == "dualsense AB:12/left grip*0.25;dualsense AB:12/right grip;odd/a*b*1.0"
    )
    pad = profile("dualsense")
    names = [actuator.name for actuator in pad.actuators]
    mapping = map_listeners(
        {"hand": "hand.L"},
        {"pad": pad},
        chosen={"hand": [Place("pad", names[0], 0.25), Place("pad", names[1], 2.0)]},
    )
    np.testing.assert_array_equal(
        mapping.blocks(np.array([[1.0, -0.5]]))["pad"][:2], [[0.25, -0.125], [2.0, -1.0]]
    )


def test_a_collection_has_the_devices_of_its_listeners(hands, tmp_path):
    device("dualsense")
    some = bpy.data.collections.new("some")
    bpy.context.scene.collection.children.link(some)
    for name in ("table", "left"):
        some.objects.link(hands[name])
    exported(tmp_path / "a.json", collection="some")
    (pad,) = read_export(tmp_path / "a.json").devices
    assert {item.listener for item in pad.actuators} == {"left"}
