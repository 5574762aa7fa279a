"""A listener whose device is calibrated: its margins, live and from a baked track, and the profile
or the text that calibrate it."""

import json
import math
from types import SimpleNamespace

import bpy
import pytest
from haptic_tracing.addon.bake import playback, storage
from haptic_tracing.addon.live_output import outputs
from haptic_tracing.addon.operators import live_output
from haptic_tracing.addon.properties import sound
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.addon.view.levels import shown_levels
from haptic_tracing.core.devices.profile_files import BUILT_IN
from haptic_tracing.core.devices.sound_card import sound_cards
from haptic_tracing.core.perception import FullScale, threshold_level
from haptic_tracing.core.render.integers import FULL_SCALE
from haptic_tracing.core.render.lane import levels_over_time

DEVICE = FullScale(((60.0, 4.0), (160.0, 12.0)))


@pytest.fixture
def hand(add_box, scene):
    source = add_box("shaker", (0, 0, 0), (1, 1, 1))
    hand = add_box("hand", (1, 0, 0), (1, 1, 1))
    source.haptics.source.enabled = hand.haptics.listener.enabled = True
    source.haptics.source.frequency, scene.frame_end = 120.0, 6
    bpy.context.view_layer.update()
    return hand.haptics.listener


def level(scene):
    session.result_of(scene)
    return shown_levels(sessions.shown(scene), False)[0]


def test_the_panel_says_whether_a_margin_is_assumed(hand, scene):
    before = level(scene)
    assert before.is_assumed
    hand.full_scale = "60 4, 160 12"
    bpy.context.view_layer.update()
    after = level(scene)
    assert after.rms == before.rms and not after.is_assumed
    change = float(threshold_level(120.0) - threshold_level(120.0, DEVICE))
    assert after.margin - before.margin == pytest.approx(change, abs=0.2)
    assert abs(change) > 5


@pytest.mark.slow
def test_a_baked_track_is_measured_by_the_device_as_it_is_now(hand, scene):
    level(scene)
    assert bpy.ops.haptic.bake() == {"FINISHED"}
    hand.full_scale = "60 4, 160 12"
    assert playback.stale_reasons(scene) == ()
    track = storage.track_of(scene)
    played = playback.calibrated(track.result(3).listeners[0])
    assert played.device == DEVICE
    samples, per_frame = track.samples / FULL_SCALE, track.sample_rate * track.frame_duration
    change = [
        levels_over_time(samples, track.sample_rate, per_frame, own)[1][0, 3]
        for own in ([played], track.result(3).listeners)
    ]
    expected = float(threshold_level(120.0, DEVICE) - threshold_level(120.0))
    assert change[0] - change[1] == pytest.approx(expected, abs=0.3)


def test_a_text_that_is_no_calibration_is_a_problem_of_the_object(hand, scene):
    hand.full_scale = "loud"
    bpy.context.view_layer.update()
    session.result_of(scene)
    (problem,) = session.problems_of(scene)
    assert problem.object == "hand" and problem.message.startswith("Full Scale: 'loud' is not")
    hand.full_scale = "160 12"
    bpy.context.view_layer.update()
    assert math.isfinite(level(scene).margin) and session.problems_of(scene) == ()


@pytest.mark.parametrize(
    "name", ["Vest with coin motors", "Xbox Wireless Controller (Bluetooth): both motors"]
)
def test_a_device_that_is_chosen_ends_what_is_assumed(hand, scene, name):
    """A vest by what Shah and others (2019) measured of a motor on the skin, in g; pads by what is
    typical of their kind, marked as an estimate."""
    bpy.context.view_layer.objects.active = bpy.data.objects["hand"]
    assert bpy.ops.haptic.calibrate_listener(actuator=name) == {"FINISHED"}
    if name.startswith("Vest"):
        points = [tuple(map(float, part.split())) for part in hand.full_scale.split(",")]
        wanted = {102.0: 0.45, 156.0: 1.05, 241.0: 2.35}
        assert dict(points) == pytest.approx({f: 9.81 * g for f, g in wanted.items()}, rel=0.01)
    else:
        assert "estimate" in hand.full_scale_source
    bpy.context.view_layer.update()
    after = level(scene)
    assert not after.is_assumed


def test_a_profile_calibrates_the_listener(hand, scene, tmp_path, monkeypatch):
    bpy.context.view_layer.objects.active = bpy.data.objects["hand"]
    unknown = bpy.ops.haptic.calibrate_listener(actuator="Toaster")
    assert unknown == {"CANCELLED"} and hand.full_scale == ""
    document = json.loads((BUILT_IN / "dualsense.json").read_text())
    document["actuators"][0] |= {"full_scale": [[60, 4], [160, 12]], "full_scale_source": "lab"}
    (tmp_path / "dualsense.json").write_text(json.dumps(document))
    monkeypatch.setattr(sound, "profile_folders", lambda: (tmp_path,))
    assert "DualSense: left grip" in live_output._calibrated_actuators(None, None, "")
    assert bpy.ops.haptic.calibrate_listener(actuator="DualSense: left grip") == {"FINISHED"}
    assert (hand.full_scale, hand.full_scale_source) == ("60 4, 160 12", "DualSense: lab")
    bpy.context.view_layer.update()
    session.result_of(scene)
    (listener,) = sessions.shown(scene).result.listeners
    assert listener.device == DEVICE


def test_a_channel_of_a_sound_card_is_chosen_and_calibrates_nothing(hand, monkeypatch):
    """What hangs on a sound card is not known."""
    device = {
        "name": "Line Out",
        "hostapi": 0,
        "max_output_channels": 2,
        "default_samplerate": 48_000.0,
    }
    module = SimpleNamespace(
        query_hostapis=lambda: [{"name": "ALSA"}], query_devices=lambda: [device]
    )
    (card,) = sound_cards(module)
    monkeypatch.setitem(outputs.running(), "line out", SimpleNamespace(profile=card))
    choice = {"listener": "hand", "place": "line out/channel 1"}
    assert bpy.ops.haptic.choose_actuator(**choice) == {"FINISHED"}
    assert bpy.data.objects["hand"].haptics.live_output.actuators == choice["place"]
    assert hand.full_scale == ""
