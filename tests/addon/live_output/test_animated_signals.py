"""Amplitude and frequency from F-curves: what is felt is the closed form, without a jump at any
frame."""

import bpy
import numpy as np
import pytest
import scipy.signal
from haptic_tracing.addon.session import session, timeline


@pytest.fixture
def hum(scene, add_box):
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    box.haptics.kappa, box.haptics.rho = 0.0, 1.0
    box.haptics.source.enabled = box.haptics.listener.enabled = True
    box.haptics.listener.limiter = False
    scene.frame_start, scene.frame_end = 1, 49
    return box


def rendered(scene):
    blocks = []
    for frame in range(1, 50):
        timeline.set_frame(scene, frame)
        block = session.result_of(scene).block
        if block is not None:
            blocks.append(block[0])
    return np.concatenate(blocks)


def key(obj, name, *pairs, interpolation="LINEAR"):
    for frame, value in pairs:
        setattr(obj.haptics.source, name, value)
        obj.haptics.source.keyframe_insert(name, frame=frame)
    from haptic_tracing.addon.blender.compatibility import fcurves_of

    for curve in fcurves_of(obj):
        for point in curve.keyframe_points:
            point.interpolation = interpolation


def test_a_keyed_frequency_is_a_sweep_whose_phase_is_the_integral(hum, scene):
    key(hum, "frequency", (1, 40.0), (49, 140.0))
    samples = rendered(scene)
    times = np.arange(len(samples)) / 8000
    sweep = np.sin(2 * np.pi * (40.0 * times + 0.5 * (100.0 / 2.0) * times**2))
    np.testing.assert_allclose(
        samples, sweep, rtol=0, atol=1e-4, err_msg="keys are single precision"
    )


def test_a_keyed_amplitude_goes_in_straight_lines_from_frame_to_frame(hum, scene):
    hum.haptics.source.frequency = 100.0
    key(hum, "amplitude", (1, 0.0), (25, 1.0), (49, 0.0))
    samples = rendered(scene)
    times = np.arange(len(samples)) / 8000
    # The corners are rounded over 8 ms, and the way to 0 ends that long before its frame does.
    lines = np.interp(times, (0.0, 1.0, 47 / 24, 2.0 - 0.008), (0.0, 1.0, 1 / 24, 0.0))
    window = scipy.signal.windows.hann(65)
    expected = np.convolve(lines, window / window.sum())[: len(times)] * np.sin(
        2 * np.pi * 100.0 * times
    )
    # In its first frame a source plays at the gain that the frame ends with.
    begun = round(8000 / 24) + 65
    np.testing.assert_allclose(samples[begun:], expected[begun:], rtol=0, atol=1e-5)


def test_moving_a_key_is_felt_and_muting_the_curve_too(hum, scene):
    from haptic_tracing.addon.blender.compatibility import fcurves_of

    key(hum, "frequency", (1, 50.0), (49, 50.0))
    first = rendered(scene)
    (curve,) = fcurves_of(hum)
    curve.keyframe_points[1].co.y = 90.0
    curve.update()
    assert not np.allclose(rendered(scene), first)
    curve.mute = True
    hum.haptics.source.frequency = 50.0
    np.testing.assert_allclose(rendered(scene), first, rtol=0, atol=1e-6)


def test_a_file_that_is_no_wav_is_a_problem_in_words_and_the_rest_is_traced(
    hum, scene, add_box, tmp_path
):
    other = add_box("other", (0, 0, 1), (1, 1, 1))
    other.haptics.source.enabled = True
    other.haptics.source.signal = "FILE"
    file = tmp_path / "noise.wav"
    file.write_bytes(b"RIFF but not a WAV")
    other.haptics.source.filepath = str(file)
    scene.frame_set(2)
    assert [source.name for source in session.result_of(scene).sources] == ["box"]
    assert any(
        "not a WAV file" in problem.message and problem.object == "other"
        for problem in session.problems_of(scene)
    )
    assert bpy.context.scene == scene
