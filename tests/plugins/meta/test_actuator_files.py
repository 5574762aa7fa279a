"""Actuators: their files, which are JSON5 where their maker wrote them, and clips for the chosen one."""

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

EMPHASES = {
    "version": {"major": 1},
    "signals": {
        "continuous": {
            "envelopes": {
                "amplitude": [
                    {"time": 0.0, "amplitude": 0.5},
                    {"time": 0.1, "amplitude": 0.5, "emphasis": {"amplitude": 1, "frequency": 0}},
                    {"time": 0.3, "amplitude": 0.5, "emphasis": {"amplitude": 1, "frequency": 1}},
                    {"time": 0.5, "amplitude": 0.5},
                ]
            }
        }
    },
}


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


def test_emphases_are_those_of_the_file(tmp_path):
    """Meta's file of a console's voice coil: 27 ms of sine at 55 Hz, 20 ms of square at 130 Hz; of
    Quest controllers, which play what it does not give: 36.4 ms at 55 Hz, 12.1 ms at 165 Hz."""
    (tmp_path / "clip.haptic").write_text(json.dumps(EMPHASES))
    ends = [
        f"frequency_{end}: {{output_frequency: {hertz}, duration_ms: {milliseconds}}}"
        for end, hertz, milliseconds in (("min", 55.0, 27.0), ("max", 130.0, 20.0))
    ]
    for emphasis, expected in (
        (f"emphasis: {{{', '.join(ends)}}}", [(55.0, 0.027, "sine"), (130.0, 0.02, "square")]),
        ("", [(55.0, 0.0364, "sine"), (165.0, 0.0121, "square")]),
    ):
        continuous = "continuous: {frequency_min: 20.0, frequency_max: 250.0}"
        (tmp_path / "clip.acf").write_text(f"{{{continuous}, {emphasis}}}")
        (channel,) = registry.read(tmp_path / "clip.haptic").channels
        found = [
            (wave.frequencies[0], wave.end - wave.start, wave.wave) for wave in channel.carriers[1:]
        ]
        for one, (hertz, seconds, wave) in zip(found, expected, strict=True):
            assert one == (hertz, pytest.approx(seconds), wave)


def test_an_actuator_of_one_frequency_plays_that(clip):
    """As of Meta's file of a console that plays amplitudes alone."""
    assert clip("{continuous: {frequency_min: 60, frequency_max: 60}}") == (60.0, ())


def tones(**amplitudes):
    """A second of tones, such as ``hz_300=0.4``."""
    times = np.arange(8000) / 8000
    waves = (
        amplitude * np.sin(2 * np.pi * int(name[3:]) * times)
        for name, amplitude in amplitudes.items()
    )
    return Export("tone", tracks=Tracks((ListenerTrack("hand"),), 8000, sum(waves)[None]))


def heard(folder):
    """The frequency at which the clip is played."""
    (channel,) = registry.read(folder / "tone.haptic").channels
    return int(np.abs(np.fft.rfft(channel.at_rate(8000)[:8000])).argmax())


def test_by_default_files_are_written_for_the_range_by_which_they_are_played(tmp_path):
    """A tone of 120 Hz, in a clip without the file beside it, is read as 120 Hz."""
    registry.write("haptic", tones(hz_120=0.5), tmp_path)
    (tmp_path / "tone.acf").unlink()
    assert abs(heard(tmp_path) - 120) <= 1


def outside(losses, low, high):
    """The share of the power outside of the range that the report says, 0 if it says none. A
    second's tone begins and ends at once, by which a few thousandths are elsewhere."""
    said = re.compile(rf"([\d.]+) ?% of the power, which lies outside of {low} to {high} Hz")
    return sum(float(found[1]) / 100 for found in map(said.search, losses) if found)


@pytest.mark.parametrize(
    ("options", "low", "high"),
    [
        ({}, 55, 200),
        ({"actuator": "voice_coil"}, 20, 250),
        ({"frequency_max": 500.0}, 55, 500),
        ({"actuator": "voice_coil", "frequency_max": 320.0}, 20, 320),
    ],
)
@pytest.mark.parametrize("hertz", [40, 120, 230, 300])
def test_tones_outside_of_the_range_are_played_at_its_ends(tmp_path, options, low, high, hertz):
    losses = registry.write("haptic", tones(**{f"hz_{hertz}": 0.5}), tmp_path, options).losses
    assert abs(heard(tmp_path) - min(max(hertz, low), high)) <= 1
    assert outside(losses, low, high) == pytest.approx(0 if low <= hertz <= high else 1, abs=0.005)
    assert f"the pitch below {low} and above {high} Hz: played as {low} and {high} Hz" in losses
    written = json.loads((tmp_path / "tone.acf").read_text())["continuous"]
    assert (written["frequency_min"], written["frequency_max"]) == (low, high)


def test_the_share_of_the_power_outside_is_said(tmp_path):
    """Of sines of 0.3 and 0.4: 0.09 to 0.16."""
    losses = registry.write("haptic", tones(hz_120=0.3, hz_300=0.4), tmp_path).losses
    assert outside(losses, 55, 200) == pytest.approx(0.16 / 0.25, abs=0.005)
