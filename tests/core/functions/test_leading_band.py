"""The band in which a source is strong: of a sine its own, of several the lowest, of every kind of
signal one."""

import pytest
from haptic_tracing.core.scene.bands import BAND_CENTRES
from haptic_tracing.core.scene.spectra import leading_band
from haptic_tracing.core.scene.values import Source, SourceKind
from haptic_tracing.core.signals import (
    Automation,
    Decay,
    Keyed,
    Loop,
    Noise,
    Pulse,
    Sampled,
    Sine,
    impact_template,
)


@pytest.mark.parametrize("band", range(6))
def test_a_sine_is_strong_in_its_own_band(band):
    assert leading_band(Source("s", "o", signal=Sine(BAND_CENTRES[band]))) == band
    assert leading_band(Source("s", "o", signal=Sine(BAND_CENTRES[band]) * Decay(0.5))) == band


@pytest.mark.parametrize(
    ("low", "band"), [(0.5, 1), (0.2, 3)]
)  # a fifth of the energy of the high one, or a 25th
def test_of_several_the_lowest_strong_one(low, band):
    assert (
        leading_band(Source("s", "o", signal=Sine(BAND_CENTRES[1]) * low + Sine(BAND_CENTRES[3])))
        == band
    )


def test_of_a_source_without_a_signal_that_of_the_default_of_its_kind():
    assert leading_band(Source("s", "o")) == 1  # 60 Hz
    assert leading_band(Source("s", "o", kind=SourceKind.TEMPORARY)) in (1, 2, 3)  # 150 Hz, damped


def test_every_signal_has_one():
    for signal in (Noise(), Pulse(20.0), Sine(0.0), Sine(60.0) * 0.0):
        assert leading_band(Source("s", "o", signal=signal)) in range(6)


def test_signals_of_every_kind_can_be_asked_again():
    """Energies are kept by signal, so every signal needs a hash."""
    curve = Automation((0.0, 1.0), (0.0, 1.0))
    loop, blow = Loop(Sampled([0.0, 1.0], 100.0)), impact_template("stone", "metal")
    for signal in (Sine(60.0) * curve, Sampled([0.0, 1.0, 0.0], 100.0), loop, blow, Keyed(curve)):
        source = Source("s", "o", signal=signal)
        assert leading_band(source) == leading_band(source)
