"""What is baked is what is traced, survives saving and loading, and is played without tracing."""

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.bake import playback, storage
from haptic_tracing.addon.bake.baking import bake_job
from haptic_tracing.addon.blender import compatibility
from haptic_tracing.addon.registration import handlers
from haptic_tracing.addon.session import session, sessions, timeline
from haptic_tracing.addon.view import explanation, paths, watched
from haptic_tracing.addon.view.render_data import Options, render_data
from haptic_tracing.command_line.playing import play
from haptic_tracing.core.render.integers import FULL_SCALE
from haptic_tracing.core.tracer import Tracer

STEP = Tracer.step


def test_samples_are_those_that_playing_gives(shaken):
    played = play(shaken, 1, 24)
    shaken.frame_set(5)
    assert bpy.ops.haptic.bake() == {"FINISHED"}
    assert shaken.frame_current == 5
    track = storage.track_of(shaken)
    assert (track.frame_start, track.frame_end) == (1, 24)
    assert [item.name for item in track.listeners] == list(played.listeners)
    assert track.samples.shape == played.samples.shape
    assert np.abs(track.samples / FULL_SCALE - played.samples).max() <= 0.5 / FULL_SCALE + 1e-9
    assert np.abs(track.samples[1, -3000:]).max() == 0  # the crate has left the ground


def test_frames_of_the_track_are_those_that_were_traced(shaken):
    traced = [step.result for step in timeline.steps(shaken, 1, 24)]
    bpy.ops.haptic.bake()
    for expected in traced:
        result = storage.track_of(shaken).result(expected.number)
        assert result.time == pytest.approx(expected.time, abs=1e-12)
        assert [s.name for s in result.sources] == [s.name for s in expected.sources]
        np.testing.assert_allclose(result.amplitudes, expected.amplitudes, rtol=0, atol=1e-6)
        for again, listener in zip(result.listeners, expected.listeners, strict=True):
            assert again.position == pytest.approx(listener.position, abs=1e-6)
        assert (result.block is None) == (expected.block is None)
        if expected.block is not None:
            assert result.first_sample == expected.first_sample
            np.testing.assert_allclose(result.block, expected.block, rtol=0, atol=1 / FULL_SCALE)
            assert np.abs(result.block[0]).max() == pytest.approx(
                np.abs(expected.block[0]).max(), abs=1 / FULL_SCALE
            )


def test_the_paths_of_a_bake_are_those_that_were_traced(shaken, playing, settle):
    traced = {step.result.number: step.result for step in timeline.steps(shaken, 1, 24)}
    bpy.ops.haptic.bake()
    drawn = 0
    for number in (2, 12, 24):
        shaken.frame_set(number)
        shown = sessions.shown(shaken)
        assert playback.is_from_track(shown.result)
        now = render_data(shown.result, shown.settings, Options(), shown.paths).paths
        then = render_data(traced[number], shown.settings, Options()).paths
        drawn += len(then.width)
        for name in ("position", "colour", "width", "arc_length"):
            found, expected = getattr(now, name), getattr(then, name)
            np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-3)
    assert drawn > 0


def test_playing_a_baked_scene_traces_nothing(shaken, monkeypatch, playing):
    bpy.ops.haptic.bake()
    steps = []
    monkeypatch.setattr(Tracer, "step", lambda self, frame: steps.append(frame.number))
    for frame in (2, 9, 3, 24):
        shaken.frame_set(frame)
        assert session.result_of(shaken).number == frame
        assert playback.is_from_track(session.result_of(shaken))
    assert steps == []
    monkeypatch.setattr(Tracer, "step", STEP)
    shaken.frame_set(25)  # beyond what was baked
    assert session.result_of(shaken).number == 25
    assert "propagate" in session.result_of(shaken).milliseconds
    shaken.haptics.bake.use_track = False
    shaken.frame_set(9)
    assert "propagate" in session.result_of(shaken).milliseconds


def test_a_bake_traces_although_a_track_is_there_and_tracing_is_off(shaken):
    bpy.ops.haptic.bake()
    first = storage.track_of(shaken)
    bpy.data.objects["shaker"].haptics.source.amplitude = 0.5
    shaken.haptics.tracing = False
    bpy.ops.haptic.bake()
    second = storage.track_of(shaken)
    assert np.abs(second.samples * 2.0 - first.samples).max() <= 2
    assert len(bpy.data.texts) == 1


def test_track_survives_saving_and_loading(shaken, tmp_path):
    bpy.ops.haptic.bake()
    before = storage.track_of(shaken)
    path = str(tmp_path / "baked.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, compress=True)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert storage.track_of(bpy.context.scene) is None
    bpy.ops.wm.open_mainfile(filepath=path)
    scene = bpy.context.scene
    after = storage.track_of(scene)
    assert np.array_equal(after.samples, before.samples)
    assert np.array_equal(after.row_gain, before.row_gain)
    assert playback.stale_reasons(scene) == ()
    assert after.digest == before.digest
    assert bpy.data.texts[0].as_string().startswith("Haptic track of scene")


def test_curves_of_the_designer_are_left_alone(shaken):
    foot = bpy.data.objects["foot"]
    foot.haptics.listener.keyframe_insert("gain", frame=3)
    for _ in range(2):
        bpy.ops.haptic.bake()
        assert {c.data_path for c in compatibility.fcurves_of(foot)} == {"haptics.listener.gain"}
    bpy.ops.haptic.delete_bake()
    assert {c.data_path for c in compatibility.fcurves_of(foot)} == {"haptics.listener.gain"}
    assert shaken.haptics.bake.track is None
    assert len(bpy.data.texts) == 0
    assert not bpy.ops.haptic.delete_bake.poll()


def test_what_can_not_be_baked_is_a_message(shaken):
    for name in ("foot", "hand"):
        bpy.data.objects[name].haptics.listener.enabled = False
    with pytest.raises(RuntimeError, match="no listener"):
        bpy.ops.haptic.bake()
    assert storage.track_of(shaken) is None
    assert bpy.data.texts.keys() == []
    for obj in shaken.objects:
        obj.haptics.enabled = obj.haptics.source.enabled = False
    with pytest.raises(RuntimeError, match="Nothing is tagged"):
        bpy.ops.haptic.bake()


def test_a_bake_that_is_stopped_leaves_everything_as_it_was(shaken):
    shaken.frame_set(3)
    baking = bake_job(shaken)
    assert baking.advance(0.0) is None
    assert baking.advance(0.0) is None
    assert 0 < baking.factor < 1
    assert "2 of 24" in baking.state
    baking.cancel()
    assert shaken.frame_current == 3
    assert storage.track_of(shaken) is None
    assert bpy.data.texts.keys() == []
    assert compatibility.fcurves_of(bpy.data.objects["foot"]) == []


def test_a_bake_in_pieces_is_the_bake_in_one_go(shaken):
    bpy.ops.haptic.bake()
    whole = storage.track_of(shaken)
    baking = bake_job(shaken)
    while (reports := baking.advance(0.0)) is None:
        pass
    pieces = storage.track_of(shaken)
    assert pieces is not whole
    assert np.array_equal(pieces.samples, whole.samples)
    assert baking.done == 25  # with the frame at which the last one ends
    assert reports == [({"INFO"}, "24 frames baked")]


def test_scenes_that_share_a_track_part_when_one_is_baked_again(shaken):
    bpy.ops.haptic.bake()
    other = shaken.copy()
    assert other.haptics.bake.track == shaken.haptics.bake.track
    shaken.frame_end = 5
    bpy.ops.haptic.bake()
    assert storage.track_of(other).frame_end == 24
    assert storage.track_of(shaken).frame_end == 5


def test_damaged_tracks_are_not_played_but_named(shaken):
    text = bpy.data.texts.new("mine")
    shaken.haptics.bake.track = text
    assert "bake again" in storage.trouble(shaken)
    for content in (b"", b"HAPTRACK", 5, "text", b"x" * 100):
        text["haptic_track"], text["haptic_track_stamp"] = content, repr(content)
        assert storage.track_of(shaken) is None
        assert storage.trouble(shaken)
        shaken.frame_set(shaken.frame_current + 1)
        assert "propagate" in session.result_of(shaken).milliseconds


def test_rigid_bodies_run_up_to_a_later_start(scene, add_box):
    add_box("floor", (0, 0, -0.1), (4, 4, 0.2), "PASSIVE").haptics.source.enabled = True
    ball = add_box("ball", (0, 0, 2.5), (0.5, 0.5, 0.5), "ACTIVE", mass=20.0)
    ball.haptics.listener.enabled = True
    whole = play(scene, 1, 40)
    late = play(scene, 10, 40)
    assert [impact.source.onset for impact in late.impacts] == pytest.approx(
        [impact.source.onset for impact in whole.impacts], abs=1e-6
    )
    assert len(whole.impacts) >= 1


def test_meters_know_the_last_second_wherever_the_track_is_entered(shaken, playing):
    shaken.frame_end = 60
    bpy.ops.haptic.bake()
    track = storage.track_of(shaken)
    shaken.frame_set(50)
    history = session.of(shaken).history
    foot = history.listeners.index("foot")
    assert history.all().shape[1] == track.sample_rate
    np.testing.assert_allclose(
        history.all()[foot],
        (track.samples[0] / FULL_SCALE)[: track.offsets[50]][-track.sample_rate :],
        rtol=1e-6,
        atol=1e-12,
    )
    shaken.frame_set(51)
    np.testing.assert_allclose(
        history.all()[foot],
        (track.samples[0] / FULL_SCALE)[: track.offsets[51]][-track.sample_rate :],
        rtol=1e-6,
        atol=1e-12,
    )


def baked_amplitudes(scene, frame):
    return storage.track_of(scene).result(frame).amplitudes


def traced_amplitudes(scene):
    """The amplitudes that are shown once Blender has evaluated the last edit."""
    bpy.context.view_layer.update()
    return session.result_of(scene).amplitudes


def test_while_the_timeline_stands_the_scene_is_shown_as_it_is_now(shaken):
    bpy.ops.haptic.bake()
    shaken.frame_set(9)
    np.testing.assert_allclose(
        traced_amplitudes(shaken), baked_amplitudes(shaken, 9), rtol=0, atol=1e-6
    )
    source = bpy.data.objects["shaker"].haptics.source
    source.amplitude = 0.05
    np.testing.assert_allclose(
        traced_amplitudes(shaken), 0.05 * baked_amplitudes(shaken, 9), rtol=0, atol=1e-6
    )
    source.amplitude, source.muted = 1.0, True
    assert not traced_amplitudes(shaken).any()
    source.muted = False
    assert (traced_amplitudes(shaken) > 0).all()
    bpy.data.objects.remove(bpy.data.objects["crate"])
    assert traced_amplitudes(shaken)[0, 0] > 0
    assert [item.name for item in session.result_of(shaken).listeners] == [
        "foot"
    ]  # the hand was on the crate


def test_a_stop_shows_the_frame_as_it_is_now(shaken, monkeypatch):
    bpy.ops.haptic.bake()
    with monkeypatch.context() as while_playing:
        for module in (playback, handlers):
            while_playing.setattr(module, "is_playing", lambda: True)
        shaken.frame_set(8)
        bpy.data.objects["shaker"].haptics.source.amplitude = 0.25
        shaken.frame_set(9)
        assert playback.is_from_track(session.result_of(shaken))
        np.testing.assert_allclose(
            session.result_of(shaken).amplitudes, baked_amplitudes(shaken, 9), rtol=0, atol=1e-6
        )
    handlers.trace_opened()  # after the stop, from a timer, which only a window has
    assert not playback.is_from_track(session.result_of(shaken))
    np.testing.assert_allclose(
        traced_amplitudes(shaken), 0.25 * baked_amplitudes(shaken, 9), rtol=0, atol=1e-6
    )


def test_the_first_frame_of_a_bake_is_felt_and_has_paths(shaken, settle):
    bpy.ops.haptic.bake()
    shaken.frame_set(1)
    levels = settle(lambda: watched.levels_of(shaken))
    assert [level.is_felt for level in levels] == [True, True]
    for name in ("foot", "hand"):
        why = settle(lambda name=name: explanation.why_silent(shaken, name))
        assert (why.notice, why.reasons) == ("", ())
    bpy.context.view_layer.objects.active = bpy.data.objects["hand"]
    path = settle(lambda: paths.path_of(shaken)).value
    assert [hop.object for hop in path.fall.hops] == ["ground", "crate"]
    result = session.result_of(shaken)
    assert result.path_objects(0, 1) == ("ground", "crate")  # which the overlay draws
