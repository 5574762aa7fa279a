"""What lies 20 dB under its listener's threshold of feeling is not rendered, by the threshold's
closed form: a (log(c f + b) / log(b))^2 - e with a = 50, c = 1 / 550, b = 1 - 250 c, e = 45."""

import math

import numpy as np
import pytest
from haptic_tracing.core.propagation.result import Propagation
from haptic_tracing.core.render.frame_result import Sounding
from haptic_tracing.core.render.mixdown import Mixdown
from haptic_tracing.core.scene.values import Listener, Source
from haptic_tracing.core.signals import Sampled, Sine

BANDS = [[1e-9, 1.0, 1e-9, 1e-9, 1e-9, 1e-9]]


def threshold(frequency):
    b = 1 - 250 / 550
    return 50 * (math.log(frequency / 550 + b) / math.log(b)) ** 2 - 45


def samples(signal, level, listener=None, bands=None):
    """A quarter of a second of a source that arrives with the amplitude ``level`` [dB]."""
    gain = np.array([[10 ** (level / 20)]])
    there = Propagation.of_gains(gain, None if bands is None else gain[:, :, None] * bands)
    listener = listener or Listener("skin", "seat")
    mixdown = Mixdown()
    for time in (0.0, 0.25, 0.5):
        state = Sounding(time, (Source("s", "seat", signal=signal),), (listener,), there)
        block = mixdown.render(time - 0.25, state)
    return block


@pytest.mark.parametrize("frequency", [20.0, 40.0, 100.0, 250.0, 400.0])
def test_tones(frequency):
    least = threshold(frequency) - 20
    assert samples(Sine(frequency), least + 0.1).any()
    assert not samples(Sine(frequency), least - 0.1).any()


def test_gain_of_the_listener_counts():
    quiet = Listener("skin", "seat", gain=0.5)
    least = threshold(100.0) - 20 + 20 * math.log10(2)
    assert samples(Sine(100.0), least + 0.1, quiet).any()
    assert not samples(Sine(100.0), least - 0.1, quiet).any()


def test_calibration_counts():
    """At 250 Hz the skin feels 10^(-10 / 20) micrometres."""
    amplitude = 0.5 * (2 * math.pi * 250) ** 2 * 1e-6  # of 0.5 micrometres [m/s^2]
    least = -10 - 20 * math.log10(0.5) - 20
    calibrated = Listener("skin", "seat", full_scale=((250.0, amplitude),))
    assert samples(Sine(250.0), least + 0.1, calibrated).any()
    assert not samples(Sine(250.0), least - 0.1, calibrated).any()


def test_bands_of_a_tone():
    """Only the band of 40 Hz arrives."""
    assert not samples(Sine(250.0), threshold(250.0), bands=BANDS).any()


def test_a_recording_may_become_louder():
    """It counts as a tone of the bound on its peak, at the frequency that is felt best."""
    recording = Sampled(np.concatenate([np.zeros(2000), np.ones(2000)]), 8000.0)
    least = -65 - 20 * math.log10(recording.peak)
    assert samples(recording, least + 0.1).any()
    assert not samples(recording, least - 0.1).any()
