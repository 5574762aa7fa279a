"""Exports as clips: one gain with headroom, without listeners who feel nothing; by definitions."""

import json
import math

import numpy as np
import pytest
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.tracks.clips import clips_of
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.perception import threshold_level

RATE = 8000


def tones(*levels, seconds=2.0, hertz=100.0):
    """Tracks of sines of these levels [dB of full scale]."""
    times = np.arange(round(seconds * RATE)) / RATE
    sine = np.sin(2 * math.pi * hertz * times)
    listeners = tuple(
        ListenerTrack(f"listener {number}", impacts=[(0.5, min(10 ** (level / 20), 1.0))])
        for number, level in enumerate(levels)
    )
    return Tracks(listeners, RATE, np.array([10 ** (level / 20) * sine for level in levels]))


@pytest.mark.parametrize("loudest", [-15.0, 0.0, 6.0])
def test_one_gain_leaves_one_decibel_below_full_scale(loudest):
    clips = clips_of(tones(loudest, loudest - 12.0))
    peaks = np.abs(clips.tracks.samples).max(axis=1)
    assert clips.gain == pytest.approx(-1.0 - loudest, abs=0.011)
    assert -1.011 <= 20 * math.log10(peaks[0]) <= -1.0 + 1e-5
    assert 20 * math.log10(peaks[0] / peaks[1]) == pytest.approx(12.0, abs=1e-4)
    strengths = [listener.impacts[0, 1] for listener in clips.tracks.listeners]
    assert strengths[0] <= 1 and strengths[1] == pytest.approx(peaks[1], rel=1e-3)


@pytest.mark.parametrize("seconds", [0.4, 20.0])
def test_who_is_below_the_threshold_of_feeling_is_left_out_by_name(seconds):
    threshold = float(threshold_level(100.0))
    clips = clips_of(tones(-20.0, threshold - 1.0, threshold + 1.0, -300.0, seconds=seconds))
    assert [item.name for item in clips.tracks.listeners] == ["listener 0", "listener 2"]
    assert clips.left_out == ("listener 1", "listener 3")
    assert clips.sentences()[1].endswith("listener 1, listener 3")


def test_a_short_blow_in_long_silence_is_felt():
    samples = np.zeros((2, 60 * RATE))
    samples[:, 30 * RATE : 30 * RATE + 400] = 0.2 * np.sin(np.arange(400) * 2 * math.pi / 32)
    samples[1] *= 0.01
    clips = clips_of(Tracks((ListenerTrack("struck"), ListenerTrack("far")), RATE, samples))
    assert clips.left_out == ("far",)


def test_where_nobody_feels_anything_all_stay():
    clips = clips_of(tones(-90.0, -100.0))
    assert len(clips.tracks.listeners) == 2 and clips.gain == pytest.approx(89.0, abs=0.011)
    silent = clips_of(Tracks((ListenerTrack("one"),), RATE, np.zeros((1, 100))))
    assert silent.gain == 0.0 and silent.sentences() == () and not silent.tracks.samples.any()


def test_the_side_car_tells_the_gain_that_gives_back_the_levels(tmp_path):
    export = Export("one", tracks=tones(-26.0, -31.0))
    clips, changes = export.as_clips()
    registry.write("wav", clips, tmp_path, {"encoding": "float32"})
    side_car = json.loads((tmp_path / "one.wav.json").read_text())
    gain = side_car["provenance"]["gain_decibels"]
    assert changes == (f"gain of all listeners: {gain:+.2f} dB",)
    for channel, original in zip(
        registry.read(tmp_path / "one.wav").channels, export.tracks.samples, strict=True
    ):
        assert channel.samples / 10 ** (gain / 20) == pytest.approx(original, abs=1e-7)
