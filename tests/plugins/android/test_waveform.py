"""Waveforms of Android against what is known of their vibration."""

import json

import numpy as np
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.scene.values import HapticScene

RATE = 8000


def test_a_tone_of_half_a_second_lasts_as_long(tmp_path):
    time = np.arange(2 * RATE) / RATE
    tone = 0.6 * np.sin(2 * np.pi * 150 * time) * ((time >= 0.5) & (time < 1))
    tracks = Tracks((ListenerTrack("hand"),), RATE, tone[None])
    (path,) = registry.write(
        "android", Export("a", HapticScene(), tracks), tmp_path, {"milliseconds": 10}
    ).files
    document = json.loads(path.read_text())
    amplitudes = np.repeat(document["amplitudes"], document["timings"])
    assert len(amplitudes) == 2000 and document["repeat"] == -1
    assert not amplitudes[:500].any() and not amplitudes[1010:].any()
    assert abs(amplitudes[510:1000] - 0.6 * 255).max() <= 1
