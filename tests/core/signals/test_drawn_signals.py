"""Drawn vibrations against their definition: the envelope, the integral of the frequency, bursts,
and what AHAP files say of both."""

import json
import math

import numpy as np
import pytest
from haptic_tracing.core.formats import registry
from haptic_tracing.core.signals import (
    Automation,
    DecayingSine,
    Drawing,
    Emphasis,
    Loop,
    Noise,
    Sine,
    signal_from_dict,
)
from mpmath import mp

RATE = 8000
AMPLITUDE = Automation((0.0, 0.1, 0.4, 0.7, 1.0), (0.0, 1.0, 0.6, 0.6, 0.0))
FREQUENCY = Automation((0.0, 0.25, 0.3, 1.0), (60.0, 60.0, 250.0, 40.0))


def test_the_envelope_is_the_lines_and_the_phase_the_integral_of_the_frequency() -> None:
    samples = Drawing(AMPLITUDE, FREQUENCY, 1.0).to_signal().sample(0, RATE, RATE)
    keys = [mp.mpf(t) for t in FREQUENCY.times.tolist()]

    def hertz(t: object) -> object:
        k = max(i for i, key in enumerate(keys[:-1]) if key <= t)
        low, high = FREQUENCY.values[k : k + 2].tolist()
        return low + (high - low) * (t - keys[k]) / (keys[k + 1] - keys[k])

    for n in range(7, RATE, 373):
        t = n / RATE
        phase = mp.quad(hertz, [*(key for key in keys if key < t), t])
        expected = np.interp(t, AMPLITUDE.times, AMPLITUDE.values) * float(
            mp.sin(2 * mp.pi * phase)
        )
        assert samples[n] == pytest.approx(expected, abs=1e-12)


def test_it_ends_at_its_duration_and_loops_from_its_beginning() -> None:
    drawing = Drawing(Automation((0.0, 2.0), (1.0, 0.0)), Automation((0.0,), (50.0,)), 0.5)
    assert drawing.to_signal().duration == 0.5
    once = drawing.to_signal().sample(0, RATE // 2, RATE)
    times = np.arange(RATE // 2) / RATE
    np.testing.assert_allclose(
        once, (1.0 - times / 2.0) * np.sin(2 * np.pi * 50.0 * times), rtol=0, atol=1e-12
    )
    looped = (
        Drawing(drawing.amplitude, drawing.frequency, 0.5, loops=True)
        .to_signal()
        .sample(0, RATE, RATE)
    )
    np.testing.assert_allclose(looped, np.concatenate([once, once]), rtol=0, atol=1e-9)


@pytest.mark.plugins
def test_an_emphasis_is_a_transient_as_core_haptics_plays_it(tmp_path) -> None:
    """The reader of AHAP files and the drawing make the same of an event, but for the square of its
    intensity."""
    parameters = [
        {"ParameterID": "HapticIntensity", "ParameterValue": 0.9},
        {"ParameterID": "HapticSharpness", "ParameterValue": 0.7},
    ]
    event = {"Event": {"Time": 0.25, "EventType": "HapticTransient", "EventParameters": parameters}}
    (tmp_path / "click.ahap").write_text(json.dumps({"Version": 1.0, "Pattern": [event]}))
    played = registry.read(tmp_path / "click.ahap").channels[0].to_signal()
    drawn = Drawing(
        Automation((0.0,), (0.0,)), FREQUENCY, 1.0, (Emphasis(0.25, 0.9**2, 0.7),)
    ).to_signal()
    np.testing.assert_allclose(
        drawn.sample(0, RATE, RATE), played.sample(0, RATE, RATE), rtol=0, atol=1e-12
    )
    found = Drawing.of(played)
    assert found is not None
    (emphasis,) = found.emphases
    assert (emphasis.time, emphasis.strength, emphasis.sharpness) == pytest.approx(
        (0.25, 0.81, 0.7), abs=1e-12
    )


@pytest.mark.parametrize("loops", (False, True))
def test_a_drawing_survives_its_signal_and_json(loops) -> None:
    drawing = Drawing(
        AMPLITUDE, FREQUENCY, 1.0, (Emphasis(0.1, 0.5, 0.25), Emphasis(0.9, 1.0, 1.0)), loops
    )
    signal = signal_from_dict(json.loads(json.dumps(drawing.to_signal().to_dict())))
    assert signal == drawing.to_signal()
    found = Drawing.of(signal)
    assert found is not None
    np.testing.assert_allclose(
        found.to_signal().sample(0, 2 * RATE, RATE),
        signal.sample(0, 2 * RATE, RATE),
        rtol=0,
        atol=1e-12,
    )
    assert len(found.emphases) == 2
    assert found.loops is loops


def test_what_can_not_be_drawn_is_no_drawing() -> None:
    drawn = Drawing(AMPLITUDE, FREQUENCY).to_signal()
    for signal in (
        Sine(60.0),
        Noise(),
        DecayingSine(),
        drawn * 0.5,
        drawn + drawn,
        Loop(drawn, 3),
        Loop(drawn, crossfade=0.1),
        None,
    ):
        assert Drawing.of(signal) is None, signal


@pytest.mark.parametrize("values", ((math.nan, 1.0, 0.5), (0.0, 1.5, 0.5), (0.0, 0.5, -0.1)))
def test_an_emphasis_has_limits(values) -> None:
    with pytest.raises(ValueError, match=r"seconds|strength|sharpness"):
        Emphasis(*values).to_signal()
