"""Vibrations of other tools as signals of sources: kept with the file, felt as they were
written."""

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.session import sessions
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.io import catalogue
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.signals import Loop

RATE = 8000
TIME = np.arange(RATE) / RATE
SWELL = 0.6 * np.sin(2 * np.pi * 80 * TIME) * np.sin(np.pi * TIME) ** 2


@pytest.fixture
def files(tmp_path):
    """One vibration in every kind of file that can be read, by ending."""
    export = Export("swell", tracks=Tracks((ListenerTrack("hand", "hand.L"),), RATE, SWELL[None]))
    written = [
        path
        for name in catalogue.readers().values()
        for path in registry.write(name, export, tmp_path).files
    ]
    return {
        path.suffix: path
        for path in written
        if path.suffix in catalogue.readers() and ".transients" not in path.name
    }


@pytest.fixture
def active(add_box):
    box = add_box("box", (0, 0, 0), (1, 1, 1), haptic=False)
    bpy.context.view_layer.objects.active = box
    return box


@pytest.mark.parametrize("suffix", list(catalogue.readers()))
def test_a_file_becomes_the_signal_of_the_active_object(files, active, traced, tmp_path, suffix):
    assert bpy.ops.haptic.import_signal(filepath=str(files[suffix])) == {"FINISHED"}
    assert (
        active.haptics.enabled
        and active.haptics.source.enabled
        and active.haptics.source.signal == "KEPT"
    )
    files[suffix].unlink()
    (source,) = traced().sources
    assert isinstance(source.signal, Loop) and source.signal.duration == float("inf")
    played = source.signal.sample(0, RATE, RATE)
    spectrum = np.abs(np.fft.rfft(played * np.hanning(RATE)))
    frequency = 100 if suffix == ".tact" else 80  # that format has strengths alone
    assert abs(int(spectrum.argmax()) - frequency) <= 3
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "kept.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "kept.blend"))
    (again,) = traced().sources
    assert again.signal == source.signal


def test_recordings_keep_as_many_samples_as_are_rendered(tmp_path, active, traced):
    from haptic_tracing.core.signals.interpolation import resample

    fast = np.tile(resample(SWELL, RATE, 48000), (2, 1)) * [[1.0], [0.5]]
    tracks = Tracks((ListenerTrack("left"), ListenerTrack("right")), 48000, fast)
    registry.write("wav", Export("two", tracks=tracks), tmp_path, {"encoding": "float32"})
    bpy.ops.haptic.import_signal(filepath=str(tmp_path / "two.wav"), channel=2, loop=False)
    (source,) = traced().sources
    assert source.signal.rate == 8000 and source.signal.duration == pytest.approx(1.0, abs=1e-3)
    np.testing.assert_allclose(source.signal.samples[50:-50], 0.5 * SWELL[50:-50], atol=2e-3)
    with pytest.raises(RuntimeError, match="no channel 3; the last one is 2"):
        bpy.ops.haptic.import_signal(filepath=str(tmp_path / "two.wav"), channel=3)


@pytest.mark.plugins
def test_what_can_not_be_is_said(tmp_path, active, add_empty):
    (tmp_path / "bad.hjif").write_text("{")
    with pytest.raises(RuntimeError, match=r"bad\.hjif: not JSON"):
        bpy.ops.haptic.import_signal(filepath=str(tmp_path / "bad.hjif"))
    with pytest.raises(RuntimeError, match=r"No such file"):
        bpy.ops.haptic.import_signal(filepath=str(tmp_path / "gone.wav"))
    assert not active.haptics.enabled and not active.haptics.source.enabled


def test_an_empty_needs_something_to_shake(files, add_empty):
    bpy.context.view_layer.objects.active = add_empty("nowhere")
    with pytest.raises(RuntimeError, match="parent it to a haptic object"):
        bpy.ops.haptic.import_signal(filepath=str(files[".wav"]))


def test_damaged_text_in_a_strangers_file_is_a_problem_in_words(active, traced):
    active.haptics.enabled = active.haptics.source.enabled = True
    active.haptics.source.signal = "KEPT"
    for text in ("{", '{"signal": "sine", "frequency": -1}', "[" * 5000):
        active.haptics.source.kept = text
        assert traced().sources == ()
        (problem,) = sessions.shown_problems(bpy.context.scene)
        assert "its kept signal is damaged: import the file again" in problem.message


def test_a_dropped_scene_is_answered_in_a_sentence(tmp_path):
    before = len(bpy.data.objects)
    assert bpy.ops.haptic.drop_scene(filepath=str(tmp_path / "a.json")) == {"CANCELLED"}
    assert len(bpy.data.objects) == before


def test_files_that_can_be_dropped():
    """Blender asks file handlers what to do with a file; in the background it can be asked which
    there are."""
    scene, tracks, sound = (
        bpy.types.FileHandler.bl_rna_get_subclass_py(name)
        for name in ("HAPTIC_FH_scene", "HAPTIC_FH_tracks", "HAPTIC_FH_sound")
    )
    assert sound.bl_import_operator == "haptic.import_sound"
    assert {".wav", ".flac", ".mp3", ".ogg"} == set(sound.bl_file_extensions.split(";"))
    assert scene.bl_import_operator == "haptic.drop_scene" and {".json", ".gz"} == set(
        scene.bl_file_extensions.split(";")
    )
    assert tracks.bl_import_operator == "haptic.import_signal" and set(catalogue.readers()) == set(
        tracks.bl_file_extensions.split(";")
    )
    # There is no viewport here.
    assert not any(handler.poll_drop(bpy.context) for handler in (scene, tracks, sound))
