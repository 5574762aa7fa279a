"""The level of a vibration: its RMS without the steady part, against closed forms."""

import numpy as np
import pytest
from haptic_tracing.core.render.levels import level_and_margin, vibration_rms

RATE = 8000
TIME = np.arange(RATE // 4) / RATE


@pytest.mark.parametrize("duty", [0.1, 0.5, 0.9])
def test_a_train_of_pulses_has_the_power_of_its_changes(duty):
    """Of pulses of height 1 for a share d of the time, d² of their power d is steady."""
    pulses = (np.arange(len(TIME)) % 200 < round(200 * duty)).astype(np.float64)
    assert vibration_rms(pulses, RATE) == pytest.approx(np.sqrt(duty * (1 - duty)), rel=1e-9)
    level, _ = level_and_margin(np.array([pulses, pulses - 5.0]), RATE)
    assert level == pytest.approx(10 * np.log10(duty * (1 - duty)), abs=1e-6)


@pytest.mark.parametrize("seconds", [0.01, 0.25])
def test_a_blow_keeps_its_level(seconds):
    """A push of 10 ms in samples that end with it, and in those of a quarter second, has nearly all
    of its energy."""
    push = np.where(TIME < 0.01, np.sin(2 * np.pi * 50 * TIME), 0.0)[: round(seconds * RATE)]
    change = 20 * np.log10(vibration_rms(push, RATE) / np.sqrt(np.mean(push**2)))
    assert -0.15 < change < 0


def test_a_tone_keeps_its_level_and_a_push_has_none():
    rows = np.array([np.sin(2 * np.pi * 60 * TIME), np.full(len(TIME), 0.7), np.zeros(len(TIME))])
    assert vibration_rms(rows, RATE) == pytest.approx([np.sqrt(0.5), 0, 0], abs=1e-9)
    assert level_and_margin(rows, RATE)[0].tolist()[1:] == [-np.inf, -np.inf]
    assert level_and_margin(np.zeros((2, 0)), RATE)[0].tolist() == [-np.inf, -np.inf]
