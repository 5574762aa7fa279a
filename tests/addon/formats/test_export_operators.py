"""File > Export, run as Blender runs it: what is written is what was traced, whole or not at
all."""

import json
import math
import threading

import bpy
import numpy as np
import pytest
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.haptic_scene import read_export
from haptic_tracing.core.formats.io import catalogue
from haptic_tracing.core.formats.io.catalogue import named
from haptic_tracing.core.formats.scene.recording import states
from haptic_tracing.core.formats.scene.recording import traced as traced_again
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from mathutils import Quaternion
from scene_files import exported


@pytest.fixture
def shaken(add_box, add_empty):
    """A floor that is shaken, a table on it that someone sits at, and a crate that slides along."""
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 13
    scene.render.fps, scene.render.fps_base = 30, 1.001
    floor = add_box("floor", (0, 0, -0.5), (10, 10, 1))
    floor.haptics.source.enabled = True
    floor.haptics.source.frequency = 80
    table = add_box("table", (1, 0, 0.5), (1, 1, 1))
    hand = add_empty("hand", (0, 0, 0.5), parent=table)
    hand.haptics.listener.enabled = True
    hand.haptics.listener.body_part = "hand.L"
    crate = add_box("crate", (-2, 0, 0.25), (0.5, 0.5, 0.5))
    crate.haptics.listener.enabled = True
    for frame, x in ((1, -2.0), (13, -1.0)):
        crate.location.x = x
        crate.keyframe_insert("location", frame=frame)
    scene.frame_set(1)
    return scene


def test_a_range_traced_again_by_the_core_gives_the_same_samples(shaken, tmp_path):
    path = tmp_path / "range.json"
    arguments = {
        "frames": "RANGE",
        "frame_start": 1,
        "frame_end": 13,
        "tracks": "wav",
        "encoding": "float32",
    }
    assert bpy.ops.export_scene.haptic_scene(filepath=str(path), **arguments) == {"FINISHED"}
    export = read_export(path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["range.json", "range.tracks.wav"]
    assert [frame.number for frame in export.recording.frames] == list(range(1, 15))
    assert export.recording.frame_rate == pytest.approx(30 / 1.001)
    blocks = [
        result.block
        for result in traced_again(export.scene, export.recording)
        if result.block is not None
    ]
    samples = np.concatenate(blocks, axis=1)
    assert samples.shape[1] == math.ceil(13 * 1.001 / 30 * 8000)
    np.testing.assert_allclose(export.tracks.samples, samples, atol=1e-5)
    assert np.abs(export.tracks.samples).max() > 0.01
    assert bpy.context.scene.frame_current == 1


def test_recorded_poses_are_those_of_blender(shaken, tmp_path):
    """Of an object that moves, turns over, rests and moves again, beside others that rest."""
    path = tmp_path / "range.json"
    scene = bpy.context.scene
    crate = bpy.data.objects["crate"]
    for frame, turn, x in ((3, 0.0, -2.0), (6, 3.0, -1.5), (9, 3.0, -1.5), (12, 6.0, -1.0)):
        crate.rotation_euler, crate.location.x = (turn, turn / 3, 0), x
        crate.keyframe_insert("rotation_euler", frame=frame)
        crate.keyframe_insert("location", frame=frame)
    exported(path, frames="RANGE", frame_start=1, frame_end=13)
    export = read_export(path)
    for number, written in states(export.scene, export.recording):
        scene.frame_set(number)
        for item in written.objects:
            expected = bpy.data.objects[item.name].matrix_world.to_quaternion()
            near = abs(expected.dot(Quaternion(item.pose.rotation)))
            assert near == pytest.approx(1, abs=1e-6)
            place = bpy.data.objects[item.name].matrix_world.translation
            assert item.pose.position == pytest.approx(tuple(place), abs=1e-6)


def test_packed_and_inline(shaken, tmp_path):
    path = tmp_path / "packed.json.gz"
    bpy.ops.export_scene.haptic_scene(
        filepath=str(path), frames="RANGE", frame_end=3, tracks="inline", compressed=True
    )
    export = read_export(path)
    assert len(export.recording.frames) == 4 and export.tracks.count == math.ceil(
        3 * 1.001 / 30 * 8000
    )
    bpy.ops.export_scene.haptic_scene(
        filepath=str(tmp_path / "without"), frames="RANGE", frame_end=3
    )
    assert read_export(tmp_path / "without.json").tracks is None


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in catalogue.formats() if name != "scene"])
def test_every_format_is_written(shaken, tmp_path, name):
    suffix = named(name).suffix
    target = tmp_path / f"ride{suffix}"
    assert bpy.ops.export_scene.haptic_tracks(
        filepath=str(target), formats={name}, frame_start=1, frame_end=13
    ) == {"FINISHED"}
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert any(path.name.endswith(suffix) for path in files) and not any(
        path.suffix == ".part" for path in files
    )
    if suffix in catalogue.readers():
        channels = [
            c for path in files if path.suffix == suffix for c in registry.read(path).channels
        ]
        assert any(channel.at_rate(8000).any() for channel in channels)


@pytest.mark.plugins
def test_options_reach_the_format(shaken, tmp_path):
    bpy.ops.export_scene.haptic_tracks(
        filepath=str(tmp_path / "a.hjif"),
        formats={"hjif"},
        frame_end=5,
        hjif_profile="Simple Parametric",
    )
    assert json.loads((tmp_path / "a.hjif").read_text())["profile"] == "Simple Parametric"
    bpy.ops.export_scene.haptic_tracks(
        filepath=str(tmp_path / "a.wav"), formats={"wav"}, frame_end=5, wav_sample_rate=4000
    )
    (channel, _) = registry.read(tmp_path / "a.wav").channels
    assert channel.sample_rate == 4000


def test_a_collection_exports_what_is_in_it(shaken, tmp_path):
    collection = bpy.data.collections.new("crates")
    bpy.context.scene.collection.children.link(collection)
    collection.objects.link(bpy.data.objects["crate"])
    collection.objects.link(bpy.data.objects["floor"])
    bpy.ops.export_scene.haptic_scene(filepath=str(tmp_path / "part.json"), collection="crates")
    scene = read_export(tmp_path / "part.json").scene
    assert [item.name for item in scene.objects] == ["crate", "floor"] and [
        item.name for item in scene.listeners
    ] == ["crate"]
    assert {contact.objects for contact in scene.contacts} == {("crate", "floor")}
    bpy.ops.export_scene.haptic_tracks(
        filepath=str(tmp_path / "part.wav"), collection="crates", frame_end=5
    )
    assert [channel.name for channel in registry.read(tmp_path / "part.wav").channels] == ["crate"]


def test_blenders_own_collection_exporter_takes_both(shaken, tmp_path):
    """As the collection's panel does it: an exporter is added, its path chosen, and everything
    exported."""
    collection = bpy.data.collections.new("all")
    bpy.context.scene.collection.children.link(collection)
    for obj in list(bpy.context.scene.collection.objects):
        collection.objects.link(obj)
    layer = bpy.context.view_layer.layer_collection.children["all"]
    bpy.context.view_layer.active_layer_collection = layer
    for number, (handler, name) in enumerate(
        (("HAPTIC_FH_scene", "all.json"), ("HAPTIC_FH_tracks", "all.wav"))
    ):
        assert bpy.ops.collection.exporter_add(name=handler) == {"FINISHED"}
        collection.exporters[number].export_properties.filepath = str(tmp_path / name)
        assert bpy.ops.collection.exporter_export(index=number) == {"FINISHED"}
    assert (tmp_path / "all.json").is_file() and (tmp_path / "all.wav").is_file()


def test_what_can_not_be_traced_writes_nothing(shaken, tmp_path):
    shaken.frame_end = 5
    for obj in shaken.objects:
        obj.haptics.listener.enabled = False
    with pytest.raises(RuntimeError, match="no listener"):
        bpy.ops.export_scene.haptic_tracks(filepath=str(tmp_path / "a.wav"))
    with pytest.raises(RuntimeError, match="is empty"):
        bpy.ops.export_scene.haptic_scene(
            filepath=str(tmp_path / "a.json"), frames="RANGE", frame_start=5, frame_end=1
        )
    with pytest.raises(RuntimeError, match="no collection 'gone'"):
        bpy.ops.export_scene.haptic_scene(filepath=str(tmp_path / "a.json"), collection="gone")
    assert not list(tmp_path.iterdir())


def ended(work):
    while (reports := work.advance(math.inf)) is None:
        pass
    return reports


def test_a_job_goes_in_pieces_and_is_cancelled_without_a_trace(shaken, tmp_path):
    from haptic_tracing.addon.blender.job import Job
    from haptic_tracing.addon.io.capture import Capture

    shaken.frame_set(7)
    finished = []
    capture = Capture(shaken, 1, 13, True, True)
    work = Job(
        "Exporting",
        capture.frames,
        capture.steps(),
        lambda _: finished.append(capture.export("x")) or [],
    )
    assert work.advance(0.0) is None and work.done == 1 and work.factor == pytest.approx(1 / 13)
    work.cancel()
    assert shaken.frame_current == 7 and not finished
    capture = Capture(shaken, 1, 13, True, True)
    work = Job(
        "Exporting",
        capture.frames,
        capture.steps(),
        lambda _: finished.append(capture.export("x")) or [],
    )
    assert ended(work) == [] and work.done == 14
    assert (
        finished[0].tracks.count == math.ceil(13 * 1.001 / 30 * 8000) and shaken.frame_current == 7
    )


@pytest.mark.parametrize("consent", [True, False])
@pytest.mark.plugins
def test_a_poor_file_replaces_another_only_with_consent(tmp_path, consent):
    from haptic_tracing.addon.blender.job import Job
    from haptic_tracing.addon.operators.exporting import track_writer

    def job(strength):
        noise = np.random.default_rng(1).uniform(-strength, strength, (1, 8000))
        export = Export("noise", tracks=Tracks((ListenerTrack("hand", "hand.L"),), 8000, noise))
        return Job(
            "Exporting",
            1,
            iter(()),
            lambda running: track_writer("wyvrn", tmp_path, {})(export, running),
        )

    def contents():
        return {
            path: path.read_bytes()
            for path in tmp_path.rglob("*")
            if path.is_file() and ".part" not in str(path)
        }

    ended(job(0.2))
    before = contents()
    second = job(0.9)
    second.asks = True
    while not second.question:
        assert second.advance(1.0) is None
    assert any("of the power" in line for line in second.question) and contents() == before
    second.answer(consent)
    reports = ended(second)
    assert (contents() != before) == consent and (
        reports == [({"WARNING"}, "Nothing was replaced")]
    ) != consent


@pytest.mark.plugins
def test_each_of_several_files_is_asked_for(tmp_path):
    from haptic_tracing.addon.blender.job import Job
    from haptic_tracing.addon.operators.exporting import track_writer

    tone = 0.5 * np.sin(2 * np.pi * 100 * np.arange(8000) / 8000)[None]
    export = Export("tone", tracks=Tracks((ListenerTrack("hand", "hand.L"),), 8000, tone))
    kept, replaced = tmp_path / "tone.hjif", tmp_path / "tone.wav"
    for path in (kept, replaced):
        path.write_text("what was there")
    writers = [track_writer(name, tmp_path, {}) for name in ("hjif", "wav")]
    job = Job("Exporting", 1, iter(()), lambda running: [w(export, running) for w in writers])
    job.asks = True
    for path in (kept, replaced):
        while not job.question:
            assert job.advance(1.0) is None
        assert job.question == (f"Replace {path.name}?",)
        job.answer(path == replaced)
    ended(job)
    assert kept.read_text() == "what was there" and replaced.read_bytes()[:4] == b"RIFF"


@pytest.mark.plugins
def test_cancelled_while_it_writes(tmp_path):
    from haptic_tracing.addon.blender.job import Cancelled, Job
    from haptic_tracing.addon.operators.exporting import track_writer

    export = Export(
        "noise", tracks=Tracks((ListenerTrack("hand", "hand.L"),), 8000, np.full((1, 8000), 0.5))
    )
    begin = threading.Event()

    def finish(running):
        begin.wait()
        return track_writer("hjif", tmp_path, {})(export, running)

    work = Job("Exporting", 1, iter(()), finish)
    assert work.advance(0.0) is None
    work.cancel()
    begin.set()
    with pytest.raises(Cancelled):
        ended(work)
    assert not list(tmp_path.iterdir())


def test_a_bake_is_exported_without_tracing(shaken, tmp_path):
    from haptic_tracing.addon.bake.playback import fitting_track

    arguments = {"formats": {"wav"}, "frame_start": 2, "frame_end": 9}
    bpy.ops.export_scene.haptic_tracks(filepath=str(tmp_path / "traced.wav"), **arguments)
    assert fitting_track(shaken, 1, 13) is None
    bpy.ops.haptic.bake()
    assert fitting_track(shaken, 1, 13) is not None and fitting_track(shaken, 1, 14) is None
    bpy.ops.export_scene.haptic_tracks(filepath=str(tmp_path / "baked.wav"), **arguments)
    one, two = (registry.read(tmp_path / f"{name}.wav").channels for name in ("traced", "baked"))
    for first, second in zip(one, two, strict=True):
        np.testing.assert_allclose(first.samples[1000:], second.samples[1000:], atol=2e-3)
    bpy.data.objects["crate"].haptics.kappa = 0.9
    assert fitting_track(shaken, 1, 13) is None


@pytest.mark.plugins
def test_losses_are_drawn_before_anything_is_written(shaken, recording_layout):
    from haptic_tracing.addon.io.capture import expected
    from haptic_tracing.addon.operators.exporting import draw_losses

    layout = recording_layout()
    draw_losses(layout, "tact", expected(shaken, True), {})
    assert layout.labels[0] == "Not in these files" and any(
        "crate" in text for text in layout.labels
    )
    layout = recording_layout()
    draw_losses(layout, "scene", expected(shaken, True), {"tracks": "wav", "encoding": "float32"})
    assert layout.labels == ["Everything is carried"]
    for obj in shaken.objects:
        obj.haptics.listener.enabled = False
    layout = recording_layout()
    draw_losses(layout, "wav", expected(shaken, True), {})
    assert layout.labels[0] == "Can't be written"


@pytest.mark.plugins
def test_endings_follow_the_format():
    from haptic_tracing.addon.operators.exporting import export_name, with_ending

    assert with_ending("/a/b.json", (".json.gz", ".json"), ".json.gz") == "/a/b.json.gz"
    assert with_ending("/a/b.JSON.GZ", (".json.gz", ".json"), ".json") == "/a/b.json"
    assert with_ending("/a/b.v2", (".wav", ".hjif"), ".hjif") == "/a/b.v2.hjif"
    assert with_ending("/a/", (".wav",), ".hjif") == "/a/"
    assert [export_name(p) for p in ("/a/b.json.gz", "/a/b.v2.hjif", "/a/b.v2", "/a/.wav")] == [
        "b",
        "b.v2",
        "b.v2",
        "haptics",
    ]


@pytest.mark.plugins
def test_tact_without_a_body_part_is_an_error_with_its_cure(shaken, tmp_path):
    for obj in shaken.objects:
        obj.haptics.listener.body_part = "NONE"
    with pytest.raises(
        RuntimeError,
        match=r"no listener is where a bHaptics device is worn: give one such a body part",
    ):
        bpy.ops.export_scene.haptic_tracks(
            filepath=str(tmp_path / "a.tact"), formats={"tact"}, frame_start=1, frame_end=3
        )
    assert list(tmp_path.iterdir()) == []
    next(
        obj for obj in shaken.objects if obj.haptics.listener.enabled
    ).haptics.listener.body_part = "foot.L"
    bpy.ops.export_scene.haptic_tracks(
        filepath=str(tmp_path / "a.tact"), formats={"tact"}, frame_start=1, frame_end=3
    )
    assert [path.suffix for path in tmp_path.iterdir()] == [".tact"]


@pytest.mark.plugins
def test_an_export_covers_the_scenes_frames_unless_told_otherwise(shaken, tmp_path):
    """Also a script's; a range of an export before is not kept for another scene."""
    path = tmp_path / "whole.json"
    shaken.frame_start, shaken.frame_end = 3, 9
    exported(path, frames="RANGE")
    assert [frame.number for frame in read_export(path).recording.frames] == list(range(3, 11))
    exported(path, frames="RANGE", frame_end=5)
    assert [frame.number for frame in read_export(path).recording.frames] == [3, 4, 5, 6]
    for operator in ("scene", "tracks", "engine"):
        known = getattr(bpy.ops.export_scene, f"haptic_{operator}").get_rna_type().properties
        assert known["frame_start"].is_skip_save and known["frame_end"].is_skip_save
