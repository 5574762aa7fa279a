"""Sources that play once per trigger, in Blender: each kind of trigger, what is baked and written
of them, and what is wrong with one."""

import math

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.bake import storage
from haptic_tracing.addon.io.capture import Capture
from haptic_tracing.addon.scene_reader.digest import changes, digest_of
from haptic_tracing.addon.session import session, sessions, timeline
from haptic_tracing.core.formats.haptic_scene import read_export, write_export
from haptic_tracing.core.formats.scene.recording import traced as traced_file
from haptic_tracing.core.render.integers import as_integers
from haptic_tracing.core.signals import Decay

FPS, G = 24, 9.81
TRIGGER = "haptics.source.trigger"


def seconds(frame):
    return (frame - 1) / FPS


@pytest.fixture
def bell(scene, add_box, add_empty):
    """A bell of 120 Hz that dies away, on the ground, and a skin there."""
    scene.frame_start, scene.frame_end = 1, 48
    ground = add_box("ground", (0, 0, -0.5), (10, 10, 1))
    bell = add_empty("bell", (0.1, 0, 0.5), ground)
    source = bell.haptics.source
    source.enabled = source.one_shot = True
    source.signal, source.frequency, source.decay = "SINE", 120.0, 0.01
    skin = add_empty("skin", (-0.1, 0, 0.5), ground).haptics.listener
    skin.enabled, skin.limiter = True, False
    return bell


def key(obj, *keys):
    for frame, value in keys:
        obj.haptics.source.trigger = value
        obj.keyframe_insert(TRIGGER, frame=frame)


def play(scene, first=1, last=48):
    return [step.result for step in timeline.steps(scene, first, last)]


def onsets(results):
    return sorted({(shot.onset, shot.strength) for result in results for shot in result.shots})


def faults(scene):
    return {
        problem.rule[0]: problem.message
        for problem in sessions.shown_problems(scene)
        if problem.rule is not None
    }


def test_keyframes_above_0_play_with_their_strength(scene, bell):
    key(bell, (5, 1.0), (10, 0.0), (20, 0.5), (20.5, 0.25))
    assert onsets(play(scene)) == [(seconds(5), 1.0), (seconds(20), 0.5), (seconds(20.5), 0.25)]


def test_markers_of_the_name_play_and_follow_their_markers(scene, bell):
    bell.haptics.source.trigger_markers = "Shot*"
    for name, frame in (("Shot", 7), ("Shot.001", 31), ("Camera", 12)):
        scene.timeline_markers.new(name, frame=frame)
    assert [onset for onset, _ in onsets(play(scene))] == [seconds(7), seconds(31)]
    scene.timeline_markers[0].frame = 9
    assert [onset for onset, _ in onsets(play(scene))] == [seconds(9), seconds(31)]


def test_a_driver_plays_in_the_frame_in_which_it_rises(scene, bell):
    driver = bell.driver_add(TRIGGER).driver
    driver.expression = "0.5 if frame % 20 > 9 else 0"
    first, second = onsets(play(scene))
    assert first == pytest.approx((seconds(10), 0.5)) and second == pytest.approx(
        (seconds(30), 0.5)
    )


@pytest.mark.slow
def test_a_part_of_a_bake_is_that_part_traced_alone(scene, bell):
    bell.driver_add(TRIGGER).driver.expression = "frame in (16, 29, 119, 128)"
    bell.haptics.source.trigger_markers = "Shot"
    scene.timeline_markers.new("Shot", frame=10)
    scene.frame_end = 136
    bpy.ops.haptic.bake()
    whole = storage.track_of(scene)
    assert len(set(whole.row_source.tolist())) == 5
    for first in (2, 18, 30, 120):
        results = timeline.results(scene, first, 136 + 1)
        blocks = [as_integers(result.block) for result in results if result.block is not None]
        part = np.concatenate(blocks, axis=1)
        assert part.any()
        assert np.array_equal(part, whole.samples[:, whole.offsets[first - 1 + 1] :])


def test_the_file_plays_what_blender_plays(scene, bell, tmp_path):
    bell.haptics.source.trigger_markers = "Shot"
    for frame in (12, 20):
        scene.timeline_markers.new("Shot", frame=frame)
    key(bell, (30, 0.5))
    results = play(scene)
    assert len(onsets(results)) == 3
    capture = Capture(scene, 1, 48, recorded=True, felt=False)
    assert len(list(capture.steps())) == 49
    write_export(capture.export("bell"), tmp_path / "bell.json")
    export = read_export(tmp_path / "bell.json")
    (source,) = export.need_scene().sources
    assert [trigger.strengths for trigger in source.triggers] == [(1.0, 1.0, 0.5)]
    again = list(traced_file(export.need_scene(), export.recording))
    for first, second in zip(results, again[:-1], strict=True):
        assert {s.name: s.amplitude for s in first.sources} == {
            s.name: s.amplitude for s in second.sources
        }
        if first.block is not None:
            assert np.abs(first.block - second.block).max() <= 1e-12


def test_a_click_on_a_frame_keeps_its_blow_after_playing_and_after_loading(scene, bell, tmp_path):
    def at_blow(frame):
        for number in range(1, frame + 1):
            scene.frame_set(number)
        result = session.result_of(scene)
        assert len(result.shots) == 1
        scene.frame_set(40)
        scene.frame_set(frame)
        assert session.result_of(scene).sources == result.sources
        return result

    key(bell, (8, 1.0))
    at_blow(8)
    driver = bell.driver_add(TRIGGER).driver
    driver.expression = "0.5 if frame > 16 else 0"
    result = at_blow(17)
    path = str(tmp_path / "bell.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    again = session.trace(bpy.context.scene, bpy.context.evaluated_depsgraph_get())
    assert [(s.name, s.amplitude) for s in again.sources] == [
        (s.name, s.amplitude) for s in result.sources
    ]
    assert again.amplitudes == pytest.approx(result.amplitudes)


def test_a_click_on_a_frame_that_was_never_played_has_its_keyframe(scene, bell):
    key(bell, (19.6, 1.0))
    scene.frame_set(20)
    assert [shot.onset for shot in session.result_of(scene).shots] == pytest.approx([seconds(19.6)])
    scene.frame_set(19)
    assert session.result_of(scene).shots == ()


def test_what_is_wrong_is_said_beside_the_property_and_the_rest_goes_on(scene, bell, add_empty):
    source = bell.haptics.source

    def said(**values):
        for name, value in values.items():
            setattr(source, name, value)
        session.trace(scene, bpy.context.evaluated_depsgraph_get())
        return faults(scene)

    assert said() == {
        "trigger": "it never plays: insert keyframes of Trigger, or choose something below"
    }
    assert said(trigger_markers="Shot") == {"trigger_markers": "there is no timeline marker 'Shot'"}
    scene.timeline_markers.new("Shot", frame=3)
    assert said() == {}
    for values, message in (
        ({"decay": 0.0}, "its signal has no end: set a decay time"),
        ({"signal": "BLAST"}, "its signal has no end: set a decay time"),
        ({"signal": "NOISE", "decay": 10.0}, "its signal lasts longer than a minute"),
        ({"signal": "FILE", "decay": 0.01}, "its signal is a WAV file, but none is chosen"),
    ):
        assert said(**values) == {"signal": message}
    add_empty("shaker", (0, 0, 0.5), bpy.data.objects["ground"]).haptics.source.enabled = True
    source.signal = "FILE"
    result = session.trace(scene, bpy.context.evaluated_depsgraph_get())
    assert [item.name for item in result.sources] == ["shaker"] and result.amplitudes.all()


def write_wav(path, samples, rate=8000):
    """With IEEE floats, which may be no numbers."""
    data = np.asarray(samples, dtype="<f4").tobytes()
    form = (
        np.array([3, 1], "<u2").tobytes()
        + np.array([rate, 4 * rate], "<u4").tobytes()
        + np.array([4, 32], "<u2").tobytes()
    )
    body = (
        b"WAVE"
        + b"fmt "
        + np.uint32(16).tobytes()
        + form
        + b"data"
        + np.uint32(len(data)).tobytes()
        + data
    )
    path.write_bytes(b"RIFF" + np.uint32(len(body)).tobytes() + body)
    return str(path)


def test_a_silent_file_and_one_that_is_too_long_are_refused(scene, bell, tmp_path):
    key(bell, (5, 1.0))
    bell.haptics.source.signal, bell.haptics.source.decay = "FILE", 0.0
    for said, path in (
        ("silent", write_wav(tmp_path / "silent.wav", np.zeros(800))),
        ("longer", write_wav(tmp_path / "long.wav", np.ones(61 * 8000))),
        ("finite", write_wav(tmp_path / "nan.wav", [0.1, math.nan])),
        ("", str(tmp_path / "missing.wav")),
    ):
        bell.haptics.source.filepath = path
        session.trace(scene, bpy.context.evaluated_depsgraph_get())
        assert said in faults(scene)["signal"]
    bell.haptics.source.filepath = write_wav(tmp_path / "good.wav", np.sin(np.arange(800)))
    session.trace(scene, bpy.context.evaluated_depsgraph_get())
    assert faults(scene) == {}


@pytest.mark.parametrize(("kind", "phase"), [("EXPLOSION", 0.005), ("GUN", 0.001)])
def test_presets_play_friedlanders_wave_at_the_current_frame(scene, bell, kind, phase):
    bell.haptics.source.one_shot = False
    scene.frame_set(6)
    bpy.context.view_layer.objects.active = bell
    assert bpy.ops.haptic.make_one_shot(kind=kind) == {"FINISHED"}
    results = play(scene, 1, 12)
    assert onsets(results) == [(seconds(6), 1.0)]
    signal = next(s for result in results for s in result.sources).signal
    t = np.arange(0, 4 * phase, phase / 10)
    np.testing.assert_allclose(
        signal.at(t, phase / 10), (1 - t / phase) * np.exp(-t / phase), atol=1e-6
    )
    assert isinstance(signal.of[1], Decay)


def test_a_front_in_a_medium_comes_when_sound_does_and_falls_with_the_distance(
    scene, add_box, add_empty
):
    air = add_box("air", (10, 0, 0), (30, 4, 4))
    air.haptics.medium = True
    blast = add_empty("blast", (0, 0, 0), None)
    blast.parent, blast.matrix_parent_inverse = air, air.matrix_basis.inverted()
    bpy.context.view_layer.update()
    bpy.context.view_layer.objects.active = blast
    bpy.ops.haptic.make_one_shot(kind="GUN")
    assert air.haptics.reference_distance == pytest.approx(0.3)
    air.haptics.reference_distance, air.haptics.absorption = 0.25, 0.05
    for d in (1.0, 8.0, 20.0):
        ear = add_empty(f"ear {d:g}", (d, 0, 0))
        ear.parent, ear.matrix_parent_inverse = air, air.matrix_basis.inverted()
        ear.haptics.listener.enabled, ear.haptics.listener.limiter, ear.haptics.listener.radius = (
            True,
            False,
            0.0,
        )
    results = play(scene, 1, 12)
    levels = next(result.amplitudes[0] for result in results if result.sources)
    names = [item.name for item in results[-1].listeners]
    heard = np.concatenate([result.block for result in results if result.block is not None], axis=1)
    for name, level, samples in zip(names, levels, heard, strict=True):
        d = float(name.split()[1])
        assert level == pytest.approx(0.25 / (0.25 + d) * math.exp(-0.05 * d), rel=1e-5)
        assert np.argmax(samples) / 8000 == pytest.approx(d / 343.0, abs=3e-4)


def test_what_makes_shots_makes_a_bake_stale(scene, bell):
    bell.haptics.source.trigger_markers = "Shot"
    marker = scene.timeline_markers.new("Shot", frame=10)
    bpy.ops.haptic.bake()

    def stale():
        return changes(storage.track_of(scene).digest, digest_of(scene))

    assert stale() == ()
    marker.frame = 12
    assert stale() == (("haptics", "bell"),)
    marker.frame = 10
    assert stale() == ()


def test_one_step_of_undo_takes_a_preset_back(scene, bell):
    bpy.context.view_layer.objects.active = bell
    assert {"REGISTER", "UNDO"} <= bpy.types.HAPTIC_OT_make_one_shot.bl_options
    bell.haptics.source.one_shot = False
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.haptic.make_one_shot(kind="GUN")
    bpy.ops.ed.undo_push(message="after")
    bpy.ops.ed.undo()
    assert not bpy.data.objects["bell"].haptics.source.one_shot
