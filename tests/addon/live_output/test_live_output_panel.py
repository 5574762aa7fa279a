"""What the panel shows of devices in every state, against a recorder that refuses what Blender
would."""

import os
import sys
from types import SimpleNamespace

import bpy
import pytest
import recording_layout
from fake_hid import until
from haptic_tracing.addon.live_output import handlers, outputs
from haptic_tracing.addon.panels import live_output
from haptic_tracing.addon.properties.preferences import preferences
from haptic_tracing.addon.registration.properties import classes_of
from haptic_tracing.core.devices.status import Status


def drawn():
    layout = recording_layout.RecordingLayout()
    for panel in classes_of(live_output):
        panel.draw(SimpleNamespace(layout=layout), bpy.context)
    return layout


def text():
    return " ".join(drawn().labels)


def find():
    bpy.ops.haptic.find_devices()
    outputs.wait_until_found()


def test_before_the_first_look_and_with_nothing_connected(hid, scene):
    assert drawn().operators == ["haptic.find_devices"]
    find()
    assert "No haptic device is connected" in drawn().labels


def test_a_device_is_offered_connected_and_shown_with_its_budget(plug, connect, felt):
    plug()
    find()
    assert "DualSense (USB)" in drawn().labels and "haptic.connect_device" in drawn().operators
    connect()
    handlers.animation_playback_pre(felt)
    until(
        lambda: (
            felt.frame_set(felt.frame_current + 1),
            outputs.running()["dualsense"].status.delay,
        )[-1]
    )
    layout = drawn()
    assert {"gain", "floor", "curve", "ceiling", "offset"} <= set(layout.properties)
    assert layout.operator_icons[layout.operators.index("haptic.connect_device")] == "UNLINKED"
    assert "Connected" in layout.labels and "-15 to 50 ms go unnoticed" in layout.labels
    assert "Auto: left grip" in layout.labels
    assert layout.operators.count("haptic.choose_actuator") == 2
    assert "Left grip of DualSense plays strength, not frequency" in text()


def test_what_a_status_says_is_shown(scene):
    layout = recording_layout.RecordingLayout()
    blocked = Status("open", "DualSense: write failed: no", 12, 3, 1, 0, 4.2, 0.004, 0.090)
    live_output._draw_status(layout, blocked, 1 / 24)
    shown = " ".join(layout.labels)
    assert "A write has been blocked for 4.2 s" in shown and "write failed" in shown
    assert "3, 1" in layout.labels and "111 ms (noticed)" in layout.labels


def test_the_budget_counts_from_the_middle_of_the_picture():
    status = Status("open", "", 1, 0, 0, 0, 0.0, 0.002, 0.012)
    assert live_output.lag_of_picture(status, 0.04) == pytest.approx(0.032)
    assert live_output.lag_of_picture(Status("open", "", 0, 0, 0, 0, 0.0, None, None), 0.04) is None


def test_a_gamepad_that_nothing_can_drive_is_named(plug, scene):
    plug(vendor=0x1234, product=0xABCD)
    find()
    assert "Fake pad is not supported" in drawn().labels
    assert outputs.inventory().devices == ()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="udev is Linux's")
def test_a_missing_permission_comes_with_a_rule_to_copy(plug, scene, monkeypatch):
    plug()
    real = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: mode == os.F_OK and real(path, mode))
    find()
    assert "/etc/udev/rules.d/70-haptic-tracing.rules" in drawn().labels
    assert "haptic.copy_udev_rule" in drawn().operators
    assert bpy.ops.haptic.copy_udev_rule(device="dualsense") == {"FINISHED"}
    assert 'ATTRS{idVendor}=="054c", ATTRS{idProduct}=="0ce6"' in outputs.found("dualsense").rule


def test_a_device_held_by_another_program_is_said(plug, felt):
    plug().open_error = "held"
    find()
    bpy.ops.haptic.connect_device(device="dualsense")
    until(lambda: "another program" in text())
    assert "Looking for it" in drawn().labels


def test_hidapi_missing_is_said(scene, monkeypatch):
    monkeypatch.setitem(sys.modules, "hidraw" if sys.platform.startswith("linux") else "hid", None)
    find()
    assert "package hidapi can't be loaded" in text()


def test_a_broken_profile_of_the_users_is_said_and_the_others_go_on(plug, scene, tmp_path):
    plug()
    folder = tmp_path / "devices"
    folder.mkdir()
    (folder / "mine.json").write_text("{")
    outputs.find((folder,))
    outputs.wait_until_found()
    assert "not JSON" in text() and "DualSense (USB)" in drawn().labels


def test_a_device_that_is_not_there_can_not_be_connected(hid, scene):
    assert bpy.ops.haptic.connect_device(device="toaster") == {"CANCELLED"}
    assert bpy.ops.haptic.copy_udev_rule(device="toaster") == {"CANCELLED"}
    assert outputs.running() == {}


def test_sound_cards_are_offered_when_wanted_and_what_is_missing_is_said(hid, scene, monkeypatch):
    monkeypatch.setitem(sys.modules, "sounddevice", None)
    find()
    assert "sound cards need" not in text().lower()
    scene.haptics.live_output.sound_cards = True
    find()
    assert "Sound cards need the Python package" in text()
    card = {
        "name": "Cushion",
        "hostapi": 0,
        "max_output_channels": 2,
        "default_samplerate": 48000.0,
    }
    monkeypatch.setitem(
        sys.modules,
        "sounddevice",
        SimpleNamespace(
            PortAudioError=OSError,
            query_hostapis=lambda: [{"name": "ALSA"}],
            query_devices=lambda: [card],
        ),
    )
    find()
    assert "Cushion (sound card, 2 channels)" in drawn().labels
    assert outputs.found("sound card Cushion").device.channels == 2


@pytest.mark.plugins
def test_players_are_looked_for_only_when_wanted(hid, scene, monkeypatch):
    from haptic_tracing.plugins.players import loopback, network

    def nobody(url):
        asked.append(url)
        raise OSError(f"no player answers at {url}")

    asked = []
    for module in (loopback, network):
        monkeypatch.setattr(module, "Connection", nobody)
    find()
    assert asked == []
    monkeypatch.setattr(preferences(), "haptic_players", True)
    find()
    assert len(asked) == 2 and all(url.startswith("ws://127.0.0.1:") for url in asked)
    assert text().count("No player answers at") == 2
