"""Templates struck at another strength, against closed forms and against SciPy."""

import math

import numpy as np
import pytest
from haptic_tracing.core.signals import (
    CORNER,
    DecayingSine,
    Impulse,
    Sampled,
    Struck,
    impact_template,
)
from scipy import integrate, signal

RATE = 8000.0
RING = DecayingSine(200.0, 0.05, 0.8)


def sampled(template, seconds=1.0):
    return template.sample(0, round(seconds * RATE), RATE)


@pytest.mark.parametrize("pitch", [0.25, 0.5, 1.3, 4.0])
def test_pitch_moves_frequency_and_decay_together(pitch):
    expected = DecayingSine(200.0 * pitch, 0.05 / pitch, 0.8)
    np.testing.assert_allclose(sampled(Struck(RING, pitch)), sampled(expected), rtol=0, atol=1e-12)
    assert Struck(RING, pitch).duration == pytest.approx(expected.duration)


def test_frequencies_that_samples_cannot_carry_are_left_out():
    assert not sampled(Struck(DecayingSine(2000.0, 0.05), 2.5)).any()


def decay_time(template):
    """By the definition: twice the centre of the energy in time."""
    times = np.linspace(0.0, np.nextafter(template.duration, 0.0), 200_001)
    energy = template.values(times, 1e-9) ** 2
    return 2.0 * integrate.simpson(times * energy, x=times) / integrate.simpson(energy, x=times)


@pytest.mark.parametrize(
    "template",
    [RING, impact_template("metal", "wood"), Impulse(0.02)],
    ids=["ring", "metal on wood", "impulse"],
)
@pytest.mark.parametrize(("pitch", "decay"), [(1.0, 0.5), (2.0, 0.2), (0.5, 0.9)])
def test_decay_is_an_envelope_by_the_decay_time(template, pitch, decay):
    times = np.arange(8000) / RATE
    envelope = np.exp(-times * (1.0 / decay - 1.0) * pitch / decay_time(template))
    found = sampled(Struck(template, pitch, decay))
    sounding = times < Struck(template, pitch, decay).duration
    wanted = (sampled(Struck(template, pitch)) * envelope)[sounding]
    assert (np.abs(found[sounding] - wanted) <= np.maximum(2e-3 * np.abs(wanted), 1e-3)).all()
    assert (
        np.abs(sampled(Struck(template, pitch))[~sounding] * envelope[~sounding]).max(initial=0.0)
        <= 1.1e-4 * template.peak
    )


def test_a_pure_ring_decays_in_its_part_of_the_time():
    """The centre in time of the energy of a ring of many periods is half its time constant."""
    ring = DecayingSine(300.0, 0.1)
    np.testing.assert_allclose(
        sampled(Struck(ring, decay=0.4)), sampled(DecayingSine(300.0, 0.04)), rtol=0, atol=2e-3
    )


@pytest.mark.parametrize("brightness", [0.0, 0.3, 0.8])
def test_brightness_is_a_shelf_of_first_order(brightness):
    """The spectrum of a broad pulse, relative to what it was; SciPy has the response of the
    shelf."""
    pulse = Sampled(
        np.concatenate([np.zeros(40), signal.windows.gaussian(81, 4.0), np.zeros(2000)]), RATE
    )
    before, after = (
        np.fft.rfft(sampled(item, 0.25)) for item in (pulse, Struck(pulse, brightness=brightness))
    )
    hertz = np.fft.rfftfreq(2000, 1 / RATE)
    heard = hertz < 600.0
    _, expected = signal.freqs([brightness / CORNER, 1.0], [1.0 / CORNER, 1.0], hertz[heard])
    np.testing.assert_allclose(
        np.abs(after[heard] / before[heard]), np.abs(expected), rtol=0, atol=0.02
    )


def test_what_is_not_changed_stays_to_the_last_bit():
    template = impact_template("stone", "wood")
    assert np.array_equal(sampled(Struck(template)), sampled(template))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"pitch": 0.1}, "pitch"),
        ({"pitch": math.nan}, "pitch"),
        ({"decay": 0.0}, "decay"),
        ({"decay": 1.1}, "decay"),
        ({"brightness": -1}, "brightness"),
    ],
)
def test_faults_name_the_argument(arguments, words):
    with pytest.raises(ValueError, match=rf"^{words}:"):
        Struck(RING, **arguments)


def test_a_template_ends_within_a_minute():
    with pytest.raises(ValueError, match=r"^of: must end within 60 seconds"):
        Struck(DecayingSine(20.0, 10.0))
