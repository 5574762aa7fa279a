"""The whole add-on with made-up devices: what is felt, when everything stops, and faults that stay
where they are."""

import threading
import time

import bpy
import haptic_tracing
import pytest
from fake_hid import RELEASE, ZERO, sounding, until
from haptic_tracing.addon.bake import playback
from haptic_tracing.addon.live_output import handlers, outputs, player
from haptic_tracing.addon.registration import handlers as addon_handlers
from haptic_tracing.addon.session import session
from haptic_tracing.core.devices.mapping import Loss
from haptic_tracing.core.message import Cause, Message
from haptic_tracing.core.tracer import Tracer


def silent(pad):
    return pad.written[-2:] == [ZERO, RELEASE]


@pytest.fixture
def sounds(plug, connect, playing):
    """A pad that is being felt."""
    pad = plug()
    connect()
    assert until(lambda: (playing(1), sounding(pad))[-1])
    return pad


def test_frames_are_felt_while_the_timeline_plays_and_pause_is_silence(sounds, playing):
    handlers.animation_playback_post()
    assert until(lambda: silent(sounds))
    sounds.written.clear()
    handlers.animation_playback_pre(bpy.context.scene)
    assert until(lambda: (playing(1), sounding(sounds))[-1])


@pytest.mark.parametrize("event", ["undo_pre", "redo_pre", "render_pre"])
def test_undo_redo_and_rendering_are_silence(sounds, event):
    for handler in getattr(bpy.app.handlers, event):
        if "live_output" in handler.__module__:
            handler(bpy.context.scene)
    assert until(lambda: silent(sounds))


@pytest.mark.slow
@pytest.mark.parametrize("animation", [True, False])
def test_the_frame_that_blender_returns_to_after_a_render_is_not_felt(
    plug, connect, felt, animation, tmp_path
):
    """Unlike one that somebody moves to afterwards."""
    handlers.animation_playback_post()
    felt.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    felt.collection.objects.link(felt.camera)
    bpy.context.view_layer.update()
    pad = plug()
    connect()
    assert until(lambda: pad.written)
    render = felt.render
    render.engine, render.resolution_x, render.resolution_y, render.filepath = (
        "CYCLES",
        8,
        8,
        str(tmp_path / "x"),
    )
    felt.cycles.samples, felt.frame_start, felt.frame_end = 1, 1, 2
    felt.frame_set(40)
    assert until(lambda: sounding(pad) and pad.written[-1] in (ZERO, RELEASE))
    pad.written.clear()
    bpy.ops.render.render(animation=animation)
    assert felt.frame_current == 40
    time.sleep(0.3)
    assert not sounding(pad)
    felt.frame_set(7)
    assert until(lambda: sounding(pad))


def test_another_file_lets_go_of_the_device(sounds):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert until(lambda: silent(sounds) and sounds.closed == 1)
    assert not outputs.running() and not player.is_playing()


def test_unregister_lets_go_of_the_device_and_ends_its_thread(sounds):
    haptic_tracing.unregister()
    try:
        assert silent(sounds) and sounds.closed == 1
        assert not [thread for thread in threading.enumerate() if thread.name.startswith("haptics")]
    finally:
        haptic_tracing.register()


def test_panic_stops_everything_and_says_so(sounds, capfd):
    assert bpy.ops.haptic.panic() == {"FINISHED"}
    assert silent(sounds) and sounds.closed == 1
    assert not outputs.running()
    assert "Info: All haptic output is off (DualSense)" in capfd.readouterr().out


@pytest.mark.slow
def test_panic_says_which_device_it_did_not_reach(sounds, plug, connect, capfd, monkeypatch):
    """One write blocks inside the system, and another pad refuses every report."""
    refusing = plug(serial="refusing", vendor=0x18D1, product=0x9400, number=1)
    connect()
    until(lambda: refusing.written)
    refusing.failing = 1_000_000
    sounds.gate.clear()
    bpy.ops.haptic.panic()
    said = capfd.readouterr().out
    assert "Unplug or switch off what still vibrates" in said
    assert "DualSense (no answer)" in said
    assert "Stadia Controller (Stadia Controller: write failed: No such device" in said
    assert "Off: -" in said


def test_disconnecting_lets_go_of_the_device(sounds):
    bpy.ops.haptic.connect_device(device="dualsense")
    assert until(lambda: silent(sounds) and sounds.closed == 1)


def test_an_error_in_tracing_is_silence(sounds, playing, monkeypatch):
    def fail(*_, **__):
        raise ZeroDivisionError("an error of the program")

    monkeypatch.setattr(Tracer, "step", fail)
    scene = bpy.context.scene
    scene.frame_current += 1  # Blender prints a handler's error and goes on
    with pytest.raises(ZeroDivisionError):
        addon_handlers.frame_change_post(scene, bpy.context.evaluated_depsgraph_get())
    assert until(lambda: silent(sounds))


def test_a_scene_that_can_not_be_traced_is_silence(sounds, playing):
    box = bpy.data.objects["box"]
    box.haptics.function, box.haptics.expression = "expression", "x * ("
    playing(1)
    assert until(lambda: silent(sounds))


def test_tracing_switched_off_is_silence(sounds, playing):
    bpy.context.scene.haptics.tracing = False
    playing(1)
    assert until(lambda: silent(sounds))


def test_another_scene_is_silence_and_then_felt_by_itself(sounds, playing, monkeypatch):
    rests = []
    monkeypatch.setattr(outputs, "rest", lambda: rests.append(True))
    second = bpy.data.scenes.new("second")
    second.collection.objects.link(bpy.data.objects["box"])
    second.collection.objects.link(bpy.data.objects["left"])
    bpy.context.window.scene = second
    second.frame_set(2)
    assert rests, "the jump from one scene to the other is not played"


@pytest.mark.slow
def test_scrubbing_is_a_short_grain_then_silence(plug, connect, felt):
    pad = plug()
    connect()
    assert until(lambda: pad.written)
    for frame in (40, 7, 8):
        pad.written.clear()
        felt.frame_set(frame)
        until(lambda: sounding(pad))
        until(lambda: pad.written[-1] == ZERO)
        drives = [report for report in pad.written if report[3] or report[4]]
        assert len(drives) <= 15, "100 ms at a report every 10 ms"


def test_bakes_and_exports_are_not_felt(plug, connect, felt):
    from haptic_tracing.addon.changes.suspension import stepped, suspended

    pad = plug()
    connect()
    for quiet in (stepped(felt), suspended()):
        with quiet:
            for frame in range(2, 20):
                felt.frame_set(frame)
    assert outputs.running()["dualsense"].status.delay is None
    assert not sounding(pad)


@pytest.mark.slow
def test_a_device_that_is_unplugged_while_playing_is_counted_and_felt_again_when_it_is_back(
    sounds, playing, hid
):
    output = outputs.running()["dualsense"]
    hid.pads.remove(sounds)
    assert until(lambda: (playing(1), handlers.rest(), output.status.losses == 1)[-1])
    assert until(lambda: "not connected" in output.status.message)
    playing(3)
    sounds.written.clear()
    hid.pads.append(sounds)
    assert until(lambda: output.status.state == "open")
    assert until(lambda: (playing(1), sounding(sounds))[-1])
    assert output.status.losses == 1 and output.status.message == ""


@pytest.mark.slow
def test_a_blocked_write_holds_up_neither_blender_nor_another_device(plug, connect, playing):
    stuck, free = plug(serial="stuck"), plug(serial="free")
    connect()
    assert until(lambda: (playing(1), sounding(stuck) and sounding(free))[-1])
    stuck.gate.clear()
    stuck.in_write.clear()
    assert until(lambda: (playing(1), handlers.rest(), stuck.in_write.is_set())[-1])
    before, kept = len(free.written), len(stuck.written)
    frame = bpy.context.scene.frame_current
    assert until(lambda: (playing(1), handlers.rest(), len(free.written) > before + 20)[-1])
    assert bpy.context.scene.frame_current > frame and len(stuck.written) == kept
    playing(3)
    output = outputs.running()["dualsense stuck"]
    assert until(lambda: output.status.writing_for > 0 and output.status.dropped_blocks > 0)
    bpy.ops.haptic.panic()
    assert until(lambda: silent(free) and free.closed == 1)
    stuck.gate.set()
    assert until(lambda: silent(stuck) and stuck.closed == 1)


def test_eight_devices_at_once(plug, connect, playing):
    pads = [plug(serial=str(number)) for number in range(8)]
    assert len(connect()) == 8
    assert until(lambda: (playing(1), all(sounding(pad) for pad in pads))[-1])
    handlers.animation_playback_post()
    assert until(lambda: all(silent(pad) for pad in pads))
    assert {pad.opened for pad in pads} == {1}


def test_devices_alike_without_a_serial_number_are_told_apart(plug, connect):
    plug(), plug()
    assert connect() == ["dualsense", "dualsense #2"]


def test_a_thousand_starts_and_stops_leave_the_device_silent_and_nothing_behind(sounds, felt):
    threads = threading.active_count()
    for number in range(1000):
        handlers.animation_playback_pre(felt)
        if number % 10 == 0:
            felt.frame_set(2 + number % 50)
        handlers.animation_playback_post()
    assert until(lambda: silent(sounds))
    assert threading.active_count() == threads
    assert (sounds.opened, sounds.closed) == (1, 0)
    assert outputs.running()["dualsense"].status.failed_writes == 0


def test_settings_of_a_device_are_followed_at_once(sounds, playing):
    settings = bpy.context.scene.haptics.live_output.devices["dualsense"]
    settings.ceiling = 0.25
    sounds.written.clear()
    assert until(lambda: (playing(1), any(max(report[3:5]) == 64 for report in sounds.written))[-1])
    sounds.written.clear()
    playing(20)
    assert all(max(report[3:5]) <= 64 for report in sounds.written)
    settings.gain = 0.0
    assert until(lambda: (playing(1), sounds.written[-1:] == [ZERO])[-1])


def test_listeners_go_to_the_actuator_at_their_body_part_or_where_they_are_sent(sounds, playing):
    result = session.result_of(bpy.context.scene)
    mapping = player.mapping_of(result, {})
    assert mapping.weights["dualsense"].tolist() == [[1, 0], [0, 1]]
    choose = bpy.ops.haptic.choose_actuator
    choose(listener="left", place="dualsense/right grip")
    choose(listener="right", place="NONE")
    mapping = player.mapping_of(result, handlers.choices(result))
    assert mapping.weights["dualsense"].tolist() == [[0, 0], [1, 0]]
    choose(listener="left", place="dualsense/left grip")  # both now
    assert player.mapping_of(result, handlers.choices(result)).weights["dualsense"].tolist() == [
        [1, 0],
        [1, 0],
    ]
    choose(listener="left", place="dualsense/right grip")
    assert player.mapping_of(result, handlers.choices(result)).weights["dualsense"].tolist() == [
        [1, 0],
        [0, 0],
    ]
    choose(listener="left", place="AUTOMATIC")
    choose(listener="right", place="AUTOMATIC")
    assert handlers.choices(result) == {}


def test_a_tone_that_the_actuator_can_not_play_is_said(sounds, playing):
    for frequency, causes in ((12.0, [Cause.OUT_OF_BAND] * 2), (150.0, [])):
        bpy.data.objects["box"].haptics.source.frequency = frequency
        playing(1)
        losses = player.mapping_of(session.result_of(bpy.context.scene), {}).losses
        assert [
            loss.message.cause for loss in losses if "BAND" in loss.message.cause.name
        ] == causes


def test_a_choice_of_a_device_that_is_not_there_is_said_and_nothing_fails(sounds, playing):
    bpy.data.objects["left"].haptics.live_output.actuators = "xbox/low motor"
    playing(1)
    result = session.result_of(bpy.context.scene)
    mapping = player.mapping_of(result, handlers.choices(result))
    assert (
        Loss("left", Message.of(Cause.ACTUATOR_GONE, actuators=("low motor of xbox",)))
        in mapping.losses
    )
    assert mapping.weights["dualsense"].tolist() == [[0, 0], [0, 1]]


def test_a_baked_track_is_felt_as_it_was_baked(plug, connect, felt, monkeypatch):
    """Playing the track sends the track's samples."""
    felt.frame_end = 12
    assert bpy.ops.haptic.bake() == {"FINISHED"}
    felt.haptics.bake.use_track = True
    plug()
    connect()
    sent = []
    output = outputs.running()["dualsense"]
    output.send = sent.append
    felt.frame_set(1)
    sent.clear()
    handlers.animation_playback_pre(felt)
    monkeypatch.setattr(playback, "is_playing", lambda: True)  # which only a window can
    for frame in range(2, 12):
        felt.frame_set(frame)
        assert playback.is_from_track(session.result_of(felt))
        assert sent[-1].shape == session.result_of(felt).block.shape
        if frame > 2:
            assert (sent[-1] == session.result_of(felt).block).all()
    assert len(sent) == 10
