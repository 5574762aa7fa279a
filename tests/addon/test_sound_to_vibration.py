"""A file, a speaker or the sequencer's sound becomes the vibration of a source; what is wrong with
it is said, and the rest goes on."""

import json
import sys
import wave
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
import recording_layout
from haptic_tracing.addon.blender import compatibility, job
from haptic_tracing.addon.io import sound_source
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.addon.view import sound_picture
from haptic_tracing.core.devices.profile_files import profile
from made_sounds import claps, drums

RATE = 16000
CONTENT_START, LEFT_HANDLE = (
    ("content_start", "left_handle")
    if bpy.app.version >= (5, 2, 0)
    else ("frame_start", "frame_final_start")
)
"""Properties of a strip: the frame at which its sound begins, and the first one at which it is
heard."""


def drawn(panel):
    layout = recording_layout.RecordingLayout()
    panel.draw(SimpleNamespace(layout=layout), bpy.context)
    return layout


def write_wav(path, samples, rate=RATE, channels=1):
    with wave.open(str(path), "wb") as file:
        file.setnchannels(channels)
        file.setsampwidth(2)
        file.setframerate(rate)
        file.writeframes((np.repeat(np.asarray(samples), channels) * 32767).astype("<i2").tobytes())
    return str(path)


def write_float_wav(path, samples):
    data = np.asarray(samples, dtype="<f4").tobytes()
    form = (
        np.array([3, 1], "<u2").tobytes()
        + np.array([RATE, 4 * RATE], "<u4").tobytes()
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


def click_at(seconds, length=2.0):
    """A click of a 2 kHz tone that dies away within 10 ms."""
    t = np.arange(round(length * RATE)) / RATE - seconds
    return np.where(
        t >= 0, 0.8 * np.sin(2 * np.pi * 2000 * t) * np.exp(-np.maximum(t, 0) / 0.01), 0.0
    )


@pytest.fixture
def machine(scene, add_box):
    """A box that is a source whose signal is a sound."""
    obj = add_box("machine", (0, 0, 0), (1, 1, 1))
    obj.haptics.source.enabled, obj.haptics.source.signal = True, "SOUND"
    obj.haptics.listener.enabled = True
    bpy.context.view_layer.objects.active = obj
    return obj


@pytest.fixture
def aud():
    """What decodes sounds."""
    return pytest.importorskip("aud", reason="this bpy is built without audio")


@pytest.fixture
def convert(machine, aud):
    """Convert with these properties. Returns the sound's properties."""

    def converted(**properties):
        sound = machine.haptics.source.sound
        for name, value in properties.items():
            setattr(sound, name, value)
        bpy.ops.haptic.convert_sound()
        return sound

    return converted


@pytest.fixture
def fails(convert):
    """What is said where that fails."""

    def said(**properties):
        with pytest.raises(RuntimeError) as error:
            convert(**properties)
        fault = bpy.context.object.haptics.source.sound.fault
        assert fault
        assert fault in str(error.value)
        return fault

    return said


def signal_of(scene):
    result = session.trace(scene, bpy.context.evaluated_depsgraph_get())
    return next(source.signal for source in result.sources if source.name == "machine")


def first_touch(scene):
    """Seconds at which the vibration begins."""
    samples = np.abs(signal_of(scene).sample(0, 40000, 8000.0))
    return float(np.argmax(samples > 0.01)) / 8000


def test_a_sound_that_is_imported_makes_the_active_object_a_source(scene, add_box, aud, tmp_path):
    box = add_box("machine", (0, 0, 0), (1, 1, 1), haptic=False)
    bpy.context.view_layer.objects.active = box
    with pytest.raises(RuntimeError, match="there is no file"):
        bpy.ops.haptic.import_sound(filepath=str(tmp_path / "gone.ogg"))
    assert not box.haptics.enabled and not box.haptics.source.enabled
    samples, rate, onsets = claps()
    path = write_wav(tmp_path / "claps.wav", samples, rate)
    assert bpy.ops.haptic.import_sound(filepath=path, loop=False) == {"FINISHED"}
    assert box.haptics.enabled and box.haptics.source.signal == "SOUND"
    assert box.haptics.source.sound.fault == ""
    assert first_touch(scene) == pytest.approx(onsets[0], abs=0.006)


def test_a_wav_file_becomes_vibration_that_is_saved_with_the_file(scene, convert, tmp_path):
    samples, rate, onsets = claps()
    path = write_wav(tmp_path / "claps.wav", samples, rate, channels=2)
    sound = convert(filepath=path, loop=False)
    assert sound.fault == ""
    before, waves = signal_of(scene), sound.waves
    bursts = before.of[1].of[0].automation
    assert [np.abs(bursts.times - onset).min() for onset in onsets] == pytest.approx(
        [0.0] * len(onsets), abs=0.010
    )
    Path(path).unlink()
    blend = str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    bpy.ops.wm.open_mainfile(filepath=blend)
    assert signal_of(bpy.context.scene) == before
    assert bpy.data.objects["machine"].haptics.source.sound.waves == waves


def test_the_same_sound_gives_the_same_vibration_and_is_heard_once(
    scene, convert, tmp_path, monkeypatch
):
    samples, rate, _ = drums()
    path = write_wav(tmp_path / "drums.wav", samples, rate)
    first = convert(filepath=path).kept
    sound_source._known.clear()
    assert convert().kept == first
    monkeypatch.setattr(sound_source, "heard", lambda samples: pytest.fail("heard again"))
    louder = convert(gain=0.5).kept
    assert louder != first
    assert convert(gain=1.0).kept == first


def test_it_is_played_in_a_scene_file_as_here(scene, convert, tmp_path):
    from haptic_tracing.core.formats import haptic_scene

    convert(filepath=write_wav(tmp_path / "click.wav", click_at(0.4)), carrier="PITCH", loop=True)
    bpy.ops.export_scene.haptic_scene(filepath=str(tmp_path / "scene.json"))
    read = haptic_scene.read_export(tmp_path / "scene.json")
    assert read.scene.sources[0].signal == signal_of(scene)
    form = json.loads((tmp_path / "scene.json").read_text())
    assert form["sources"][0]["signal"]["signal"] == "loop"


@pytest.mark.parametrize(
    ("ending", "names"), [("flac", "FLAC"), ("ogg", "OGG VORBIS"), ("mp3", "MP3 MP3")]
)
def test_other_formats_are_read(scene, convert, aud, tmp_path, ending, names):
    container, codec = (names.split() * 2)[:2]
    plain = aud.Sound.file(write_wav(tmp_path / "click.wav", click_at(0.5)))
    path = str(tmp_path / f"click.{ending}")
    kinds = (getattr(aud, f"CONTAINER_{container}"), getattr(aud, f"CODEC_{codec}"))
    plain.write(path, RATE, 1, aud.FORMAT_S16, *kinds, 128000, 1024)
    convert(filepath=path, loop=False)
    assert first_touch(scene) == pytest.approx(
        0.5, abs=0.010 if ending == "flac" else 0.03
    )  # the others smear and delay


@pytest.mark.parametrize("is_packed", [False, True])
def test_a_strip_plays_at_its_time_in_the_scene(scene, convert, tmp_path, is_packed):
    scene.frame_start, scene.render.fps = 11, 25
    editor = scene.sequence_editor_create()
    strip = compatibility.strips_of(editor).new_sound(
        "clap", write_wav(tmp_path / "click.wav", click_at(0.5)), 1, 36
    )
    if is_packed:
        strip.sound.pack()
        (tmp_path / "click.wav").unlink()
    convert(origin="SEQUENCER", strip="clap")
    assert first_touch(scene) == pytest.approx(1.0 + 0.5, abs=0.010)
    setattr(strip, CONTENT_START, 6)  # 0.2 s before the scene's first frame
    convert()
    assert first_touch(scene) == pytest.approx(0.5 - 0.2, abs=0.010)
    setattr(strip, CONTENT_START, 11)
    setattr(strip, LEFT_HANDLE, 16)
    other = compatibility.strips_of(editor).new_sound(
        "late", write_wav(tmp_path / "late.wav", click_at(0.1)), 2, 11
    )
    setattr(other, LEFT_HANDLE, 18)  # its click is cut away
    convert(strip="")
    assert first_touch(scene) == pytest.approx(0.5, abs=0.010)


def test_the_volume_of_a_strip_and_its_fades_count(scene, convert, tmp_path):
    t = np.arange(2 * RATE) / RATE
    editor = scene.sequence_editor_create()
    strip = compatibility.strips_of(editor).new_sound(
        "hum", write_wav(tmp_path / "hum.wav", 0.5 * np.sin(2 * np.pi * 200 * t)), 1, 1
    )
    strip.volume = 0.5
    convert(origin="SEQUENCER")
    assert signal_of(scene).of[0].of[0].at(np.array([1.0]), 1e-3) == pytest.approx(0.25, rel=0.03)
    strip.volume = 0.0
    strip.keyframe_insert("volume", frame=1)
    strip.volume = 1.0
    strip.keyframe_insert("volume", frame=49)
    for curve in compatibility.fcurves_of(scene):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    convert()
    assert signal_of(scene).of[0].at(np.array([0.5, 1.0, 1.5]), 1e-3) == pytest.approx(
        [0.125, 0.25, 0.375], rel=0.05
    )


def test_a_speaker_plays_from_its_strip_on_with_its_volume_and_pitch(scene, convert, tmp_path):
    machine = bpy.context.object
    scene.frame_set(13)  # Blender puts the strip here
    bpy.ops.object.speaker_add()
    speaker = bpy.context.object
    bpy.context.view_layer.objects.active = machine
    speaker.data.sound = bpy.data.sounds.load(write_wav(tmp_path / "click.wav", click_at(0.5)))
    convert(origin="SPEAKER", speaker=speaker, gain=0.5)
    assert first_touch(scene) == pytest.approx(0.5 + 0.5, abs=0.010)  # 12 frames of 24 a second
    full = np.abs(signal_of(scene).sample(0, 16000, 8000.0)).max()
    speaker.data.volume = 0.5
    convert()
    assert np.abs(signal_of(scene).sample(0, 16000, 8000.0)).max() == pytest.approx(
        full / 2, rel=0.02
    )
    speaker.data.pitch = 2.0
    convert()
    assert first_touch(scene) == pytest.approx(0.5 + 0.25, abs=0.010)


def test_the_panel_says_what_has_changed_in_the_scene_since(scene, convert, tmp_path):
    """Strips and speakers that are moved, cut, faded or muted after the conversion."""
    from haptic_tracing.addon.panels.sound import HAPTIC_PT_sound

    def has_changed():
        return "Changed since it was converted" in drawn(HAPTIC_PT_sound).labels

    machine = bpy.context.object
    path = write_wav(tmp_path / "click.wav", click_at(0.5))
    bpy.ops.object.speaker_add()
    speaker = bpy.context.object
    speaker.data.sound = bpy.data.sounds.load(path)
    bpy.context.view_layer.objects.active = machine
    strips = compatibility.strips_of(scene.sequence_editor_create())
    strip, other = (strips.new_sound(name, path, k, 20) for k, name in enumerate("ab", 1))

    def fade():
        strip.keyframe_insert("volume", frame=1)
        strip.volume = 0.2
        strip.keyframe_insert("volume", frame=9)

    changes = [
        lambda: setattr(strip, CONTENT_START, 30),
        lambda: setattr(strip, LEFT_HANDLE, 33),
        lambda: setattr(other, "mute", True),
        fade,
        lambda: setattr(scene.render, "fps", 48),
        lambda: setattr(scene, "frame_start", 5),
    ]
    convert(origin="SEQUENCER")
    for change in changes:
        scene.frame_set(scene.frame_current + 1)
        assert not has_changed()
        change()
        assert has_changed()
        convert()
    convert(strip="a")
    other.mute = False
    assert not has_changed()
    convert(origin="SPEAKER", speaker=speaker)
    assert not has_changed()
    for name, value in (("volume", 0.5), ("pitch", 2.0), ("muted", True)):
        setattr(speaker.data, name, value)
        assert has_changed()
        if name != "muted":
            convert()


def test_the_devices_best_frequency_is_that_of_its_profile(scene, convert, tmp_path):
    path = write_wav(tmp_path / "click.wav", click_at(0.5))
    convert(filepath=path, carrier="DEVICE", device="xbox", loop=False)
    assert signal_of(scene).of[0].of[1].frequency == 250.0


@pytest.mark.plugins
def test_of_a_devices_resonances_the_best_is_that_nearest_to_where_skin_feels_best(
    scene, convert, tmp_path
):
    assert profile("switch-pro").best_frequency == 320.0  # and not 160 Hz
    path = write_wav(tmp_path / "click.wav", click_at(0.5))
    convert(filepath=path, carrier="DEVICE", device="switch-pro", loop=False)
    assert signal_of(scene).of[0].of[1].frequency == 320.0


def test_what_is_wrong_with_a_sound_is_said_and_the_rest_goes_on(
    scene, convert, fails, tmp_path, add_box
):
    other = add_box("other", (0.9, 0, 0), (1, 1, 1))
    other.haptics.source.enabled = True
    good = write_wav(tmp_path / "click.wav", click_at(0.5))
    convert(filepath=good)
    kept = signal_of(scene)
    silent = write_wav(tmp_path / "silent.wav", np.zeros(1000))
    broken = tmp_path / "broken.wav"
    broken.write_bytes(b"RIFF but no more")
    faults = {
        "": "choose a file first",
        str(tmp_path / "missing.wav"): "there is no file",
        silent: "silent",
        write_float_wav(tmp_path / "nan.wav", np.full(1000, np.nan)): "not finite",
        str(broken): "broken.wav",
        write_wav(tmp_path / "slow.wav", np.ones(100), 1): "samples a second",
        write_wav(tmp_path / "faint.wav", 0.001 * click_at(0.5)): "louder than the gate",
    }
    for path, fault in faults.items():
        assert fault in fails(filepath=path)
        assert signal_of(scene) == kept  # what was made before still plays
    assert {source.name for source in session.result_of(scene).sources} == {"machine", "other"}
    assert "muted" in fails(origin="SEQUENCER", strip="nothing")
    assert "speaker" in fails(origin="SPEAKER")
    assert "profile" in fails(origin="FILE", filepath=good, carrier="DEVICE", device="none")
    assert convert(carrier="FIXED").fault == ""


def test_a_missing_file_is_said_as_soon_as_it_is_chosen(machine, tmp_path):
    sound = machine.haptics.source.sound
    sound.filepath = str(tmp_path / "missing.wav")
    assert "missing.wav" in sound.fault
    sound.filepath = write_wav(tmp_path / "there.wav", click_at(0.5))
    assert sound.fault == ""


def test_a_blender_without_audio_says_so_in_the_panel(machine, tmp_path, monkeypatch):
    from haptic_tracing.addon.panels.sound import HAPTIC_PT_sound

    monkeypatch.setitem(
        sys.modules, "aud", None
    )  # as in builds without it, Blender 4.2 as a module among them
    machine.haptics.source.sound.filepath = write_wav(tmp_path / "click.wav", click_at(0.5))
    with pytest.raises(RuntimeError, match="this Blender is built without audio"):
        bpy.ops.haptic.convert_sound()
    assert "This Blender is built without audio" in " ".join(drawn(HAPTIC_PT_sound).labels)


def test_a_source_whose_sound_is_not_converted_says_so(scene, machine):
    bpy.context.view_layer.update()
    session.result_of(scene)
    assert any("Convert Sound" in problem.message for problem in sessions.shown_problems(scene))


def test_a_strangers_vibration_is_checked(scene, machine):
    machine.haptics.source.sound.kept = '{"signal": {"signal": "sine", "frequency": 1e99}}'
    machine.haptics.source.sound.waves = "no hexadecimals"
    bpy.context.view_layer.update()
    session.result_of(scene)
    assert any("damaged" in problem.message for problem in sessions.shown_problems(scene))
    assert not sound_picture.picture("no hexadecimals", (1, 0, 0), (1, 1, 1)).any()
    assert not sound_picture.picture("abc123", (1, 0, 0), (1, 1, 1)).any()


def test_the_panel_shows_what_is_set_what_is_wrong_and_the_waves(convert, fails, tmp_path):
    from haptic_tracing.addon.panels.sound import HAPTIC_PT_sound

    assert HAPTIC_PT_sound.poll(bpy.context)
    sound = convert(filepath=write_wav(tmp_path / "click.wav", click_at(0.5)))
    layout = drawn(HAPTIC_PT_sound)
    assert {"filepath", "loop", "carrier", "frequency", "gain"} <= set(layout.properties)
    assert "The vibration, and over it the sound" in layout.labels
    assert "Changed since it was converted" not in layout.labels
    sound.gain = 2.0
    assert "Changed since it was converted" in drawn(HAPTIC_PT_sound).labels
    sound.carrier = "PITCH"
    assert "frequency" in drawn(HAPTIC_PT_sound).properties
    fails(filepath=write_wav(tmp_path / "silent.wav", np.zeros(1000)))
    assert "The sound is silent" in drawn(HAPTIC_PT_sound).labels
    for origin, property in (("SPEAKER", "speaker"), ("SEQUENCER", "strip")):
        bpy.context.scene.sequence_editor_create()
        sound.origin = origin
        assert property in drawn(HAPTIC_PT_sound).properties
    bpy.context.object.haptics.source.signal = "SINE"
    assert not HAPTIC_PT_sound.poll(bpy.context)


def test_the_picture_has_the_sound_and_over_it_its_vibration(convert, tmp_path):
    t = np.arange(2 * RATE) / RATE
    loud = np.where(t < 1, 0.8, 0.1) * np.sin(2 * np.pi * 200 * t)
    sound = convert(filepath=write_wav(tmp_path / "two.wav", loud), gain=0.5)
    pixels = sound_picture.picture(sound.waves, (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    heights = (pixels > 0.1).sum(axis=0)  # of each column and colour
    assert heights[64, 2] == pytest.approx(256, abs=8)
    assert heights[64, 0] == pytest.approx(128, abs=8)
    assert heights[192, 2] == pytest.approx(32, abs=8)
    assert heights[192, 0] == pytest.approx(16, abs=2)


def test_the_search_of_a_device_offers_the_profiles(machine):
    definition = type(machine.haptics.source.sound).__annotations__["device"]
    offered = definition.keywords["search"](machine.haptics.source.sound, bpy.context, "")
    assert "dualsense" in offered and offered == sorted(offered)


@pytest.mark.slow
@pytest.mark.parametrize("minutes", [2, pytest.param(10, marks=pytest.mark.more)])
def test_minutes_are_converted_in_steps_that_can_be_stopped(scene, machine, aud, tmp_path, minutes):
    """No step takes long: each is one of 8 seconds of sound, with no more than 150 MB above the
    sound itself."""
    import tracemalloc

    t = np.arange(48000, dtype=np.float32) / 48000
    path = write_wav(
        tmp_path / "long.wav",
        np.tile(0.3 * np.sin(2 * np.pi * 90 * t) * (np.sin(2 * np.pi * 1.0 * t) > 0), 60 * minutes),
        48000,
    )
    machine.haptics.source.sound.filepath = path
    work = sound_source.Conversion(scene, machine)
    assert work.step_count == 15 * minutes
    running = job.Job("Converting", work.step_count, work.steps(), lambda running: [])
    assert running.advance(0.0) is None
    running.cancel()
    with pytest.raises(job.Cancelled):
        running.advance(0.0)
    assert machine.haptics.source.sound.kept == ""
    tracemalloc.start()
    assert sum(1 for _ in sound_source.Conversion(scene, machine).steps()) == 15 * minutes
    assert tracemalloc.get_traced_memory()[1] < (60 * minutes * 16000 * 4 + 150e6)
    tracemalloc.stop()
    assert len(machine.haptics.source.sound.kept) < 2e5 * minutes
    assert signal_of(scene).duration == pytest.approx(60.0 * minutes, abs=0.02)


@pytest.mark.parametrize(
    "way",
    [
        "save as",
        "save a copy",
        pytest.param(
            "append",
            marks=pytest.mark.skipif(
                bpy.app.version < (4, 3), reason="Blender does not report imports"
            ),
        ),
    ],
)
def test_a_path_leads_to_the_same_file_from_another_folder(scene, machine, tmp_path, way):
    """As it does for Blender's own sound."""
    here, there = tmp_path / "here" / "scene.blend", tmp_path / "there" / "new" / "scene.blend"
    for path in (here, there):
        path.parent.mkdir(parents=True)
    write_wav(here.parent / "click.wav", click_at(0.5))
    bpy.ops.wm.save_as_mainfile(filepath=str(here))
    rule = scene.haptics.impact_table.items.add()
    own = bpy.data.sounds.load("//click.wav")
    own.use_fake_user = True
    holders = [machine.haptics.source, machine.haptics.source.sound, rule]
    for holder in holders:
        holder.filepath = own.filepath
    sound = machine.haptics.source.sound
    sound.is_edited = False
    if way == "append":
        bpy.ops.wm.save_mainfile()
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        bpy.ops.wm.save_as_mainfile(filepath=str(there))
        bpy.ops.wm.append(directory=f"{here}/Object/", filename="machine")
        (machine,) = bpy.data.objects
        holders = [machine.haptics.source, machine.haptics.source.sound]
        expected = "//../../here/click.wav"
    else:
        bpy.ops.wm.save_as_mainfile(filepath=str(there), copy=way == "save a copy")
        assert not sound.is_edited and sound.fault == ""
        expected = own.filepath
    assert [holder.filepath for holder in holders] == [expected] * len(holders)
    if way == "save a copy":
        assert expected == "//click.wav"
        bpy.ops.wm.open_mainfile(filepath=str(there))
        (machine,) = (obj for obj in bpy.data.objects if obj.name == "machine")
        assert machine.haptics.source.filepath == "//../../here/click.wav"
