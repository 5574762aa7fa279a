"""The range of frequencies of an actuator's file, which is JSON5 where its maker wrote it."""

import json
import re

import numpy as np
import pytest
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.plugins.meta.json5 import as_json

MAKERS = r"""
// An actuator, as its maker describes one.
{
  metadata: { device: 'controller\'s "left"', version: "1.0.0", /* of { the file */ },
  continuous: { gain: 1.0, emphasis_ducking: 0.5, frequency_min: 55.0, frequency_max : 200, },
}
"""


@pytest.fixture
def clip(tmp_path):
    """A clip of frequency 1 beside an actuator's file."""
    points = [{"time": time, "amplitude": 0.5} for time in (0.0, 0.5)]
    envelopes = {"amplitude": points, "frequency": [{"time": 0.0, "frequency": 1.0}]}
    document = {"version": {"major": 1}, "signals": {"continuous": {"envelopes": envelopes}}}
    (tmp_path / "clip.haptic").write_text(json.dumps(document))

    def read(text):
        (tmp_path / "clip.acf").write_text(text)
        reading = registry.read(tmp_path / "clip.haptic")
        return reading.channels[0].carriers[0].frequencies[0], reading.losses

    return read


def test_its_makers_text_is_the_json_that_it_means():
    found = json.loads(re.sub(r",(\s*})", r"\1", as_json(MAKERS)))  # without trailing commas
    assert found["metadata"]["device"] == 'controller\'s "left"'
    assert found["continuous"]["frequency_max"] == 200


def test_the_range_is_read(clip):
    assert clip(MAKERS) == (200.0, ())
    assert clip(MAKERS.replace("200", "320")) == (320.0, ())
    assert clip('{"continuous": {"frequency_min": 20, "frequency_max": 90}}') == (90.0, ())


@pytest.mark.parametrize("text", ["{", "{continuous: 'loud'}", "[" * 200, "{a: .5}", ""])
def test_a_damaged_one_is_not_used_and_named(clip, text):
    frequency, (loss,) = clip(text)
    assert frequency == 200.0 and loss.startswith("clip.acf ")


@pytest.mark.parametrize("piece", ["/*", "//", "'", '"', '"\\"', "a", "a ", "$:", "/"])
def test_no_text_takes_long(piece):
    """A megabyte of anything is gone through once."""
    assert as_json(piece * (2**20 // len(piece))) is not None


def test_by_default_files_are_written_for_the_range_by_which_they_are_played(tmp_path):
    """A tone of 120 Hz, in a clip without the file beside it, is read as 120 Hz."""
    tone = 0.5 * np.sin(2 * np.pi * 120 * np.arange(8000) / 8000)
    export = Export("tone", tracks=Tracks((ListenerTrack("hand"),), 8000, tone[None]))
    registry.write("haptic", export, tmp_path)
    (tmp_path / "tone.acf").unlink()
    (channel,) = registry.read(tmp_path / "tone.haptic").channels
    spectrum = np.abs(np.fft.rfft(channel.at_rate(8000)[:8000]))
    assert abs(int(spectrum.argmax()) - 120) <= 1


def test_what_the_range_cuts_is_said(tmp_path):
    high = 0.5 * np.sin(2 * np.pi * 300 * np.arange(8000) / 8000)
    export = Export("tone", tracks=Tracks((ListenerTrack("hand"),), 8000, high[None]))
    losses = registry.write("haptic", export, tmp_path).losses
    assert any("of the power, which lies outside of 55 to 200 Hz" in loss for loss in losses)
