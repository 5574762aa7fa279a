"""What belongs to a range of frames, and to a scene: the contacts that each frame has, from the
beginning of the first frame to the end of the last one."""

import json
import struct
import wave

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.bake import storage
from haptic_tracing.addon.blender.compatibility import fcurves_of
from haptic_tracing.addon.session import session

RATE = 24
UP, DOWN = 3.5, 0.5


@pytest.fixture
def pair(scene, add_box):
    """A floor that hums, and a block on it that feels."""
    floor = add_box("floor", (0, 0, -0.5), (20, 20, 1))
    block = add_box("block", (0, 0, DOWN), (1, 1, 1))
    floor.haptics.source.enabled = block.haptics.listener.enabled = True
    scene.render.fps = RATE
    return floor, block


def keyed(block, *heights):
    """Frames and heights of an object."""
    for frame, height in heights:
        block.location.z = height
        block.keyframe_insert("location", index=2, frame=frame)
    for curve in fcurves_of(block):
        for key in curve.keyframe_points:
            key.interpolation = "CONSTANT"


def written(folder, first, last):
    """The samples (n,) of the only listener, as exported, and their rate."""
    path = folder / "felt.wav"
    bpy.ops.export_scene.haptic_tracks(
        filepath=str(path), formats={"wav"}, frame_start=first, frame_end=last
    )
    data = path.read_bytes()  # the module wave of Python 3.11 reads no WAVE_FORMAT_EXTENSIBLE
    (rate,) = struct.unpack_from("<I", data, 24)
    return np.frombuffer(data.split(b"data", 1)[1][4:], dtype="<i2") / 32768, rate


@pytest.mark.parametrize("before, after", [(DOWN, UP), (UP, DOWN)], ids=["lifted", "set down"])
def test_the_first_interval_has_the_contacts_of_the_first_frame(pair, tmp_path, before, after):
    """Lifted, or set down, in one step: the same is felt wherever the range begins."""
    keyed(pair[1], (-20, before), (2, after))
    count = 8000 // RATE
    in_the_middle, _ = written(tmp_path, -2, 5)
    at_the_start, _ = written(tmp_path, 1, 5)
    begin = len(in_the_middle) - len(at_the_start)
    np.testing.assert_allclose(at_the_start, in_the_middle[begin:], atol=2e-4)
    first, second = (
        np.abs(at_the_start[k * count + 50 : (k + 1) * count]).max() / np.abs(at_the_start).max()
        for k in (0, 1)
    )  # without what the limiter holds back
    assert 0.5 < first <= 1 and second == pytest.approx(float(after == DOWN), abs=0.02)


def test_a_range_lasts_as_long_as_what_blender_mixes_of_it(pair, scene, tmp_path):
    pytest.importorskip("aud", reason="this bpy is built without audio")
    scene.frame_start, scene.frame_end = 1, 72
    mixed = tmp_path / "mixed.wav"
    bpy.ops.sound.mixdown(filepath=str(mixed), container="WAV", codec="PCM", format="S16")
    with wave.open(str(mixed)) as file:
        seconds = file.getnframes() / file.getframerate()  # whole buffers
    samples, rate = written(tmp_path, 1, 72)
    assert seconds == pytest.approx(len(samples) / rate, abs=0.5 / RATE)


def test_both_ends_of_a_range_count_baked_and_exported(pair, scene, tmp_path):
    scene.frame_start, scene.frame_end = 1, 72
    samples, rate = written(tmp_path, 1, 72)
    assert len(samples) == 3 * rate
    bpy.ops.haptic.bake()
    track = storage.track_of(scene)
    assert (track.frame_start, track.frame_end, track.duration) == (1, 72, 3.0)
    baked, _ = written(tmp_path, 1, 72)  # read from the bake
    described = json.loads((tmp_path / "felt.wav.json").read_text())
    gain = 10 ** (described["provenance"]["gain_decibels"] / 20)
    steps = gain / 2 + 1  # half a step of the bake, made louder, and half a step of either file
    np.testing.assert_allclose(baked, samples, atol=steps / 32767)


@pytest.fixture
def other(pair, scene):
    """The same objects in a scene that no window shows, where the block is lifted at frame 10."""
    other = bpy.data.scenes.new("other")
    for obj in pair:
        other.collection.objects.link(obj)
        scene.collection.objects.unlink(obj)
    keyed(pair[1], (1, DOWN), (10, UP))
    return other


def test_a_scene_that_no_window_shows_is_traced_in_its_own_frame(other):
    for frame, touches in ((10, False), (1, True), (10, False), (1, True)):
        other.frame_set(frame)
        gain = session.result_of(other).gains[0, 0]
        assert (gain > 0) == touches
    bpy.context.window.scene = other
    bpy.context.evaluated_depsgraph_get()  # before Blender 5 it writes to objects from here on
    other.frame_set(1)
    assert session.result_of(other).gains[0, 0] == gain


def test_what_is_animated_in_it_counts(pair, other):
    for frame, amplitude in ((1, 1.0), (5, 0.5)):
        pair[0].haptics.source.amplitude = amplitude
        pair[0].keyframe_insert("haptics.source.amplitude", frame=frame)
    found = []
    for frame in (1, 5):
        other.frame_set(frame)
        found.append(session.result_of(other).sources[0].amplitude)
    assert found == pytest.approx([1.0, 0.5])
