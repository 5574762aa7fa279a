"""Meters, reasons and modes in a scene: panels, operators, and the picture that is drawn."""

from itertools import pairwise
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
import recording_layout
from haptic_tracing.addon.bake import playback
from haptic_tracing.addon.live_output.unfelt import device_words
from haptic_tracing.addon.panels import result as result_panel
from haptic_tracing.addon.panels import scene as scene_panel
from haptic_tracing.addon.registration.properties import classes_of
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.addon.view import explanation, meters, watched
from haptic_tracing.core.message import Cause, Message
from haptic_tracing.pictures import picture
from haptic_tracing.pictures.shown import meters_above


@pytest.fixture
def felt(scene, add_box, add_empty):
    """A sine on the ground, a foot on it; a hand on a crate 4 cm above it, with its own muted
    source; two seconds at 25 Hz."""
    ground = add_box("ground", (0, 0, -0.1), (4, 4, 0.2))
    crate = add_box("crate", (1, 0, 0.29), (0.5, 0.5, 0.5))
    shaker = add_empty("shaker", (-0.25, 0, 0), ground)
    shaker.haptics.source.enabled = True
    for name, parent, part in (("foot", ground, "foot.L"), ("hand", crate, "hand.R")):
        listener = add_empty(name, (0, 0, 0), parent)
        listener.haptics.listener.enabled = True
        listener.haptics.listener.body_part = part
    scene.render.fps = 25
    scene.frame_start = 1
    for frame in range(1, 51):
        scene.frame_set(frame)
    return scene


def _drawn(panel):
    layout = recording_layout.RecordingLayout()
    if not hasattr(panel, "poll") or panel.poll(bpy.context):
        panel.draw(SimpleNamespace(layout=layout), bpy.context)
    return layout


def _activate(name):
    bpy.context.view_layer.objects.active = bpy.data.objects[name]


def test_levels_are_worked_out_once_a_frame(felt, settle):
    foot, hand = settle(lambda: watched.levels_of(felt))
    assert foot.is_felt
    assert foot.rms == pytest.approx(
        20 * np.log10(session.result_of(felt).amplitudes[0, 0] / np.sqrt(2)), abs=0.1
    )
    assert hand.is_silent
    assert watched.levels_of(felt)[0] is foot
    felt.frame_set(51)
    assert settle(lambda: watched.levels_of(felt))[0] is not foot


def test_samples_are_rendered_where_they_are_shown_or_asked_for(felt, settle):
    """Frames that follow each other unseen have none; the first draw shows the frame as if it
    lasted, and the next frames are heard."""
    assert not sessions.shown(felt).samples.size
    assert settle(lambda: watched.levels_of(felt))[0].rms == pytest.approx(
        20 * np.log10(session.of(felt).shown.result.amplitudes[0, 0] / np.sqrt(2)), abs=0.1
    )
    for frame in range(51, 61):
        felt.frame_set(frame)
        settle(lambda: watched.levels_of(felt))
    assert sessions.shown(felt).samples.shape == (2, 3200)


def test_a_script_gets_the_samples_of_the_frames_that_it_asks_for(felt):
    latency = round(0.005 * 8000)  # of the limiter
    for frame in (50, 51, 52):
        if frame > felt.frame_current:
            felt.frame_set(frame)
        result = session.result_of(felt)
        expected = result.amplitudes[0, 0] * np.sin(
            2 * np.pi * 60 * (result.first_sample + np.arange(320) - latency) / 8000
        )
        assert result.block[0] == pytest.approx(expected, abs=1e-6)


def test_scope_is_of_the_active_listener_or_of_the_strongest(felt, settle):
    bpy.context.view_layer.objects.active = None
    assert settle(lambda: watched.watched(felt)) == "foot"
    _activate("hand")
    assert watched.watched(felt) == "hand"
    _activate("crate")
    assert watched.watched(felt) == "hand", "what is no listener does not change it"


def test_the_strongest_listener_stays_watched_in_silence(felt, settle, add_empty):
    bpy.context.view_layer.objects.active = None
    arm = add_empty("arm", (0, 0, 0), bpy.data.objects["crate"])
    arm.haptics.listener.enabled = True
    felt.frame_set(20)
    assert settle(lambda: watched.watched(felt)) == "foot"
    bpy.data.objects["shaker"].haptics.source.muted = True
    felt.frame_set(1)
    assert all(level.is_silent for level in settle(lambda: watched.levels_of(felt)))
    assert watched.watched(felt) == "foot"


def test_why_silent_names_the_gap_and_then_the_muted_source(felt, settle):
    why = settle(lambda: explanation.why_silent(felt, "hand"))
    (reason,) = why.reasons
    assert (why.notice, why.is_current) == ("", True)
    assert (reason["first"], reason["second"], reason["distance"]) == (
        "ground",
        "crate",
        pytest.approx(0.04, abs=1e-6),
    )
    assert explanation.why_silent(felt, "hand").reasons[0] is reason
    assert settle(lambda: explanation.why_silent(felt, "foot")) == explanation.Explanation()
    bpy.data.objects["shaker"].haptics.source.muted = True
    felt.frame_set(51)
    assert settle(lambda: explanation.why_silent(felt, "foot")).reasons == (
        Message.of(Cause.MUTED, "shaker", source="shaker"),
    )
    assert "no listener" in explanation.why_silent(felt, "crate").notice


def test_why_silent_says_when_nothing_is_traced(felt):
    felt.haptics.tracing = False
    assert explanation.why_silent(felt, "hand").notice.startswith("Tracing is switched off")
    session.clear()
    assert (
        explanation.why_silent(felt, "hand").notice
        == "Tracing is switched off: tick the box of the panel Haptic Tracing"
    )
    felt.haptics.tracing = True
    assert "press Trace This Frame" in explanation.why_silent(felt, "hand").notice


def test_without_a_device_nothing_is_said_of_devices(felt):
    assert device_words(felt, "hand") == ""


def test_silence_panel_has_the_remedy(felt, settle):
    _activate("hand")
    layout = settle(lambda: _drawn(scene_panel.HAPTIC_PT_why))
    assert layout.properties == ["contact_tolerance"] and layout.operators == []
    _activate("foot")
    assert "= Margin" in settle(lambda: _drawn(scene_panel.HAPTIC_PT_why)).labels


def test_the_list_is_in_the_viewport_or_in_the_sidebar(felt, settle):
    foot, hand = settle(lambda: watched.levels_of(felt))
    in_viewport = settle(lambda: _drawn(result_panel.HAPTIC_PT_result))
    assert not {"foot", "hand"} & set(in_viewport.labels)
    felt.haptics.meters.show = False
    labels = settle(lambda: _drawn(result_panel.HAPTIC_PT_result)).labels
    assert {"foot", "hand", foot.margin_text(), hand.margin_text()} <= set(labels)


def choose_mode(mode):
    bpy.ops.wm.context_set_enum(data_path="scene.haptics.mode", value=mode)


def test_modes_by_one_click(felt, settle):
    def gains():
        return session.result_of(felt).amplitudes[0].tolist()

    before = gains()
    assert before[1] == 0
    choose_mode("MN")
    assert gains() == [1, 1]
    assert settle(lambda: watched.levels_of(felt))[1].is_felt  # although nothing plays
    felt.haptics.tracing = False
    choose_mode("HT")
    assert gains() == pytest.approx(before)  # although edits are not traced


def test_compare_panel_shows_all_modes_side_by_side(felt, settle):
    labels = settle(lambda: _drawn(result_panel.HAPTIC_PT_comparison)).labels
    shown = dict(pairwise(labels))
    values = [labels[place + 1] for place, label in enumerate(labels) if label == "hand"]
    assert len(values) == 4 and values[:2] == ["—", "—"] and values[3] == "0"
    assert shown["Haptic Tracing (HT)"] == shown["All Alike (MN)"] == "foot"


def test_every_panel_of_the_result_draws_without_one(scene):
    for panel in classes_of(result_panel):
        assert isinstance(_drawn(panel).labels, list)


@pytest.mark.slow
def test_picture_has_the_meters_at_the_upper_left(felt, tmp_path):
    if not picture.starts_gpu():
        assert bpy.app.version < (5, 2), (
            "Blender 5.2 on can draw off-screen with Mesa: install libegl1 and libgl1-mesa-dri"
        )
        pytest.skip("before Blender 5.2 nothing can be drawn without a window")
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler = (0, -9, 1), (1.5, 0, 0)
    felt.collection.objects.link(camera)
    felt.camera = camera
    bpy.context.view_layer.update()
    result, size = session.result_of(felt), (960, 540)
    plain, metered = (
        picture.viewport_picture(felt, result, size, meters=metered).astype(int)
        for metered in (False, True)
    )
    changed = np.abs(plain - metered).max(axis=2) > 20
    ((left, bottom, right, top),) = meters_above(felt, result, size, 1.0).bounds
    inside = np.zeros(size[::-1], dtype=bool)
    inside[: size[1] - int(bottom) + 3, : int(right) + 3] = True
    assert changed[inside].mean() > 0.5 * (right - left) * (top - bottom) / inside.sum()
    assert changed[~inside].mean() < 0.1  # labels that made way


def test_outside_a_viewport_nothing_is_drawn(felt):
    meters.draw_pixels()
    assert not meters._shown


@pytest.mark.parametrize("plays", [False, True])
def test_another_mode_is_traced_although_a_track_is_there(felt, monkeypatch, plays):
    bpy.ops.haptic.bake()
    monkeypatch.setattr(playback, "is_playing", lambda: plays)
    felt.frame_set(20)
    assert playback.is_from_track(session.result_of(felt)) == plays
    choose_mode("MN")
    felt.frame_set(21)
    assert not playback.is_from_track(session.result_of(felt))
    assert session.result_of(felt).amplitudes[0].tolist() == [1, 1]
    choose_mode("HT")
    felt.frame_set(22)
    assert playback.is_from_track(session.result_of(felt)) == plays


def test_a_device_that_is_not_felt_at_the_listener_is_named(felt, monkeypatch):
    """The mapping is the real one, of a real profile; only that it is connected is made up."""
    from haptic_tracing.addon.live_output import outputs
    from haptic_tracing.core.devices.profile_files import BUILT_IN, load_profiles

    profiles, _ = load_profiles([BUILT_IN])
    profile = next(
        p for p in profiles.values() if any("hand.R" in a.body_parts for a in p.actuators)
    )
    monkeypatch.setattr(outputs, "running", lambda: {"pad": SimpleNamespace(profile=profile)})
    monkeypatch.setattr(outputs, "version", lambda: -1)
    assert device_words(felt, "hand") == ""
    assert "no device has an actuator at foot.L" in device_words(felt, "foot")
    _activate("foot")
    assert any("actuator" in label for label in _drawn(scene_panel.HAPTIC_PT_why).labels)
