"""Parametric haptics of OpenXR against what is known of their vibration."""

import json

import numpy as np
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.scene.values import HapticScene

RATE = 8000


def written(tmp_path, samples, impacts=()):
    impacts = np.array(impacts, dtype=np.float64).reshape(-1, 2)
    tracks = Tracks((ListenerTrack("hand", impacts=impacts),), RATE, samples[None])
    export = Export("a", HapticScene(), tracks)
    (path,) = registry.write("openxr", export, tmp_path).files
    return json.loads(path.read_text())["vibrations"]


def test_a_tone_is_two_lines(tmp_path):
    time = np.arange(3 * RATE) / RATE
    (call,) = written(tmp_path, 0.5 * np.sin(2 * np.pi * 260 * time))
    assert call["streamFrameType"] == 0 and call["transients"] == []
    for points, expected, error in (
        (call["amplitudePoints"], 0.5, 0.005),
        (call["frequencyPoints"], (260 - 20) / 480, 0.005),
    ):
        assert points[-1]["time"] == 3e9
        assert all(abs(point["value"] - expected) < error for point in points)


def test_impacts_are_transients(tmp_path):
    time = np.arange(RATE) / RATE
    click = np.exp(-(time - 0.4) / 0.01) * np.sin(2 * np.pi * 200 * (time - 0.4)) * (time >= 0.4)
    (call,) = written(tmp_path, 0.8 * click, [(0.4, 1.0)])
    (transient,) = call["transients"]
    assert transient["time"] == 400_000_000
    assert abs(transient["frequency"] * 480 + 20 - 200) < 20


def test_minutes_are_a_stream_that_plays_what_one_call_would(tmp_path):
    """The amplitude of a tone that is made stronger and weaker slowly, 0.5 + 0.4 sin(2 pi 0.7 t)."""
    time = np.arange(150 * RATE) / RATE
    swell = 0.5 + 0.4 * np.sin(2 * np.pi * 0.7 * time)
    calls = written(tmp_path, swell * np.sin(2 * np.pi * 100 * time))
    assert [call["streamFrameType"] for call in calls] == [1, *[2] * (len(calls) - 2), 3]
    assert len(calls) > 2
    begin, times, values = 0, [], []
    for call in calls:
        points = call["amplitudePoints"]
        assert len(points) <= 500 and len(call["frequencyPoints"]) <= 500
        times += [begin + point["time"] for point in points]
        values += [point["value"] for point in points]
        begin += points[-1]["time"]
    assert begin == 150e9
    # A value is the mean of its step and the one before, 50 ms: late by 25 ms.
    played = np.interp(time, np.array(times) / 1e9, values)
    late = 0.5 + 0.4 * np.sin(2 * np.pi * 0.7 * (time - 0.0125))
    assert np.abs(played - late)[800:-800].max() < 0.03
