"""Rows of a lane: levels and thresholds over time, and their picture."""

from xml.etree import ElementTree

import numpy as np
import pytest
from haptic_tracing.core.perception import threshold_level
from haptic_tracing.core.render import lane
from haptic_tracing.core.render.lane import level_and_threshold

RATE = 8000.0


def test_level_and_threshold_of_a_sine_are_those_of_its_amplitude_and_frequency():
    time = np.arange(2000) / RATE
    for frequency in (60.0, 250.0):
        sine = np.array([0.3, 0.01])[:, None] * np.sin(2 * np.pi * frequency * time)
        level, threshold = level_and_threshold(sine, RATE)
        assert level == pytest.approx(20 * np.log10(np.array([0.3, 0.01]) / np.sqrt(2)), abs=0.01)
        # `threshold_level` is an amplitude.
        rms = float(threshold_level(frequency)) - 20 * np.log10(np.sqrt(2))
        assert threshold == pytest.approx(rms, abs=0.2)
    level, threshold = level_and_threshold(np.zeros((1, 2000)), RATE)
    assert np.isneginf(level).all() and np.isnan(threshold).all()


def test_the_picture_of_a_tone_is_a_line_at_its_level():
    """The SVG, read by an XML parser: 600 columns, the box 60 high for 60 dB."""
    tone = 0.1 * np.sqrt(2) * np.sin(2 * np.pi * 250 * np.arange(16000) / RATE)
    found = ElementTree.fromstring(lane.svg(tone, RATE))
    paths = {one.get("class"): one.get("d") for one in found}
    line = np.array([point.split() for point in paths["level"][1:].split("L")], dtype=float)
    assert len(line) == 600 and line[50:, 1] == pytest.approx(20.0, abs=0.15)
    assert paths.keys() == {"grid", "felt", "threshold", "level"}
    silent = ElementTree.fromstring(lane.svg(np.zeros(0), RATE))
    assert all(place.endswith(" 60.0") for place in silent[-1].get("d")[1:].split("L"))
