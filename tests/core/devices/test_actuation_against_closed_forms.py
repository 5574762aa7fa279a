"""Amplitude and frequency of signals whose spectra are known, and samples that change their
rate."""

import math
from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.core.devices.actuation import (
    HOP,
    SampleActuation,
    ToneActuation,
    calibrated,
    checked_block,
)
from haptic_tracing.core.devices.high_pass import HighPass
from haptic_tracing.core.devices.profile_files import profile
from haptic_tracing.core.devices.profiles import Calibration
from haptic_tracing.core.devices.resampling import Resampler
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter
from two_tones import TWO_TONES

RATE = 8000
DUALSENSE, XBOX = profile("dualsense"), profile("xbox")
SETTLED = slice(6, None)


def sine(frequency, amplitude=1.0, seconds=0.5, rate=RATE):
    return amplitude * np.sin(2 * np.pi * frequency * np.arange(round(seconds * rate)) / rate)


def tones_of(device, *rows, rate=RATE, calibrations=None, cut=None):
    actuation = ToneActuation(device, device.family, rate)
    actuation.calibrate(calibrations or {})
    block = np.array(rows)
    steps = [
        step for part in np.split(block, cut or [], axis=1) for step in actuation.process(part)
    ]
    return np.array([step.tones.amplitudes for step in steps]), np.array(
        [step.tones.frequencies for step in steps]
    )


@pytest.mark.parametrize("rate", [4000, 8000, 44100, 48000])
@pytest.mark.parametrize("frequency", [60.0, 100.0, 160.0, 200.0, 250.0, 320.0, 500.0, 900.0])
def test_a_sine_is_one_tone_with_its_amplitude_and_frequency(frequency, rate):
    amplitudes, frequencies = tones_of(
        TWO_TONES, sine(frequency, 0.7, rate=rate), sine(frequency, 0.01, rate=rate), rate=rate
    )
    taken, other = (0, 1) if frequency < 225.0 else (1, 0)
    assert amplitudes[SETTLED, taken] == pytest.approx(0.7, rel=0.03)
    assert amplitudes[SETTLED, 2 + taken] == pytest.approx(0.01, rel=0.03)
    assert (amplitudes[SETTLED, other] < 0.01).all()
    assert frequencies[SETTLED, taken] == pytest.approx(frequency, rel=0.03)


@pytest.mark.parametrize("crossing", np.arange(205.0, 246.0, 5.0))
def test_a_tone_near_the_crossover_is_never_split_into_two_that_beat(crossing):
    amplitudes, _ = tones_of(TWO_TONES, sine(crossing), sine(crossing))
    assert (np.minimum(amplitudes[SETTLED, 0], amplitudes[SETTLED, 1]) == 0.0).all()
    assert amplitudes[SETTLED, :2].max(axis=1) == pytest.approx(1.0, abs=0.01)


def test_two_tones_are_told_apart():
    amplitudes, frequencies = tones_of(
        TWO_TONES, sine(80, 0.5) + sine(400, 0.3), sine(60, 0.2) + sine(800, 0.6)
    )
    assert amplitudes[SETTLED] == pytest.approx(
        np.broadcast_to([0.5, 0.3, 0.2, 0.6], amplitudes[SETTLED].shape), rel=0.04
    )
    assert frequencies[SETTLED] == pytest.approx(
        np.broadcast_to([80, 400, 60, 800], frequencies[SETTLED].shape), rel=0.04
    )


def test_a_sine_rises_from_silence_within_30_ms_and_is_seen_in_the_step_in_which_it_starts():
    start = round(0.1 * RATE)
    signal = np.concatenate([np.zeros(start), sine(200)])
    amplitudes, _ = tones_of(DUALSENSE, signal, signal)
    first = start // round(HOP * RATE)
    assert (amplitudes[:first] == 0.0).all()
    assert amplitudes[first, 0] > 0.1
    assert amplitudes[first + 3, 0] > 0.9


def test_a_motor_pair_is_driven_by_frequency():
    amplitudes, _ = tones_of(XBOX, sine(50, 0.8))
    assert amplitudes[SETTLED] == pytest.approx(
        np.broadcast_to([0.8, 0.0], amplitudes[SETTLED].shape), abs=0.05
    )
    amplitudes, _ = tones_of(XBOX, sine(200, 0.8))
    assert amplitudes[SETTLED] == pytest.approx(
        np.broadcast_to([0.0, 0.8], amplitudes[SETTLED].shape), abs=0.02
    )


def test_noise_has_the_amplitude_of_the_sine_with_the_same_power():
    """Parseval: the mean square of the steps is that of the samples, times two (a sine of amplitude
    a has a²/2)."""
    noise = np.random.default_rng(5).normal(0.0, 0.05, RATE * 10)
    band = np.fft.rfft(noise)
    frequencies = np.fft.rfftfreq(len(noise), 1 / RATE)
    band[(frequencies < 10) | (frequencies >= 1000)] = 0
    amplitudes, _ = tones_of(DUALSENSE, noise, noise)
    assert np.mean(amplitudes[SETTLED, 0] ** 2) == pytest.approx(
        2 * np.mean(np.fft.irfft(band) ** 2), rel=0.02
    )


@settings(deadline=None)
@given(cuts=st.lists(st.integers(0, 2000), max_size=8), seed=st.integers(0, 2**32 - 1))
def test_steps_do_not_depend_on_how_the_signal_is_cut_into_blocks(cuts, seed):
    signal = np.random.default_rng(seed).normal(0.0, 0.1, (2, 2000))
    whole = tones_of(TWO_TONES, *signal)
    parts = tones_of(TWO_TONES, *signal, cut=sorted(cuts))
    assert np.allclose(whole[0], parts[0], atol=1e-12) and np.allclose(
        whole[1], parts[1], atol=1e-6
    )


@settings(deadline=None, max_examples=30)
@given(sizes=st.lists(st.integers(1, 500), min_size=1, max_size=20))
def test_offsets_are_a_steady_grid_over_all_blocks(sizes):
    actuation = ToneActuation(DUALSENSE, DUALSENSE.family, RATE)
    taken, times = 0, []
    for size in sizes:
        times += [taken / RATE + step.offset for step in actuation.process(np.zeros((2, size)))]
        taken += size
    assert times == pytest.approx([i * HOP for i in range(taken // round(HOP * RATE))], abs=1e-12)


@settings(deadline=None)
@given(seed=st.integers(0, 2**32 - 1), scale=st.floats(0.1, 1.0))
def test_amplitude_scales_with_the_signal(seed, scale):
    signal = np.random.default_rng(seed).normal(0.0, 0.1, (2, 1000))
    expected = scale * tones_of(DUALSENSE, *signal)[0]
    expected[expected < 0.002] = 0.0  # below -54 dB devices are silent
    assert np.allclose(expected, tones_of(DUALSENSE, *(scale * signal))[0], rtol=1e-9)


def test_amplitudes_stay_in_range_for_signals_beyond_full_scale():
    amplitudes, frequencies = tones_of(TWO_TONES, 50 * np.sign(sine(100)), np.full(4000, 1e6))
    assert (
        (amplitudes >= 0.0).all() and (amplitudes <= 1.0).all() and np.isfinite(frequencies).all()
    )


def test_silence_stays_silent_at_the_resting_tones():
    amplitudes, frequencies = tones_of(TWO_TONES, np.zeros(4000), np.full(4000, 1e-5))
    assert (amplitudes == 0.0).all()
    assert (frequencies == np.array([160.0, 320.0, 160.0, 320.0])).all()


def test_frequencies_are_held_to_the_actuators_band():
    narrow = replace(
        TWO_TONES,
        actuators=tuple(replace(actuator, band=(150.0, 250.0)) for actuator in TWO_TONES.actuators),
    )
    _, frequencies = tones_of(narrow, sine(60) + sine(600), sine(160))
    assert (frequencies[SETTLED, :2] == np.array([150.0, 250.0])).all()


@given(
    amplitude=st.floats(0.002, 1.0),
    more=st.floats(0.0, 1.0),
    calibration=st.builds(
        Calibration,
        gain=st.floats(1.0, 10.0),
        floor=st.floats(0.0, 0.99),
        exponent=st.floats(0.1, 10.0),
    ),
)
def test_calibration_follows_its_formula_and_never_falls(amplitude, more, calibration):
    gain, floor, exponent = calibration.gain, calibration.floor, calibration.exponent
    expected = floor + (1 - floor) * min(gain * amplitude, 1.0) ** exponent
    value = calibrated(np.array(amplitude), calibration)
    assert value == pytest.approx(expected, rel=1e-12)
    assert calibrated(np.array(amplitude + more), calibration) >= value
    assert calibrated(np.zeros(3), calibration).tolist() == [0.0] * 3


def test_a_calibration_in_place_of_the_profiles_counts_for_its_actuator_alone():
    amplitudes, _ = tones_of(
        DUALSENSE,
        sine(200, 0.2),
        sine(200, 0.2),
        calibrations={"left grip": Calibration(gain=2.0, floor=0.5)},
    )
    assert amplitudes[SETTLED] == pytest.approx(
        np.broadcast_to([0.7, 0.2], amplitudes[SETTLED].shape), rel=0.02
    )


@pytest.mark.parametrize(
    ("rate_in", "rate_out"),
    [(8000, 3000), (44100, 3000), (48000, 8000), (3000, 8000), (8000, 8000), (4000, 48000)],
)
@pytest.mark.parametrize("frequency", [5.0, 150.0, 700.0, 1000.0])
def test_resampling_a_sine_gives_the_same_sine_later(rate_in, rate_out, frequency):
    resampler = Resampler(1, rate_in, rate_out)
    output = resampler.process(sine(frequency, rate=rate_in, seconds=0.4)[None])[0]
    times = np.arange(len(output)) / rate_out - resampler.delay
    settled = times > 0.02
    np.testing.assert_allclose(
        output[settled], np.sin(2 * np.pi * frequency * times[settled]), rtol=0, atol=2e-3
    )
    assert len(output) / rate_out == pytest.approx(0.4, abs=resampler.delay + 2 / rate_out)


@pytest.mark.parametrize("frequency", [1900.0, 2500.0, 3500.0])
def test_resampling_leaves_nothing_of_what_the_lower_rate_can_not_carry(frequency):
    output = Resampler(1, 8000, 3000).process(sine(frequency)[None])[0]
    assert np.abs(output[100:]).max() < 5e-3


@pytest.mark.slow
@settings(deadline=None)
@given(
    cuts=st.lists(st.integers(0, 1500), max_size=8),
    rates=st.sampled_from([(8000, 3000), (3000, 8000), (44100, 8000), (8000, 8000)]),
)
def test_resampling_does_not_depend_on_how_the_signal_is_cut(cuts, rates):
    signal = np.random.default_rng(1).normal(size=(2, 1500))
    whole = Resampler(2, *rates).process(signal)
    resampler = Resampler(2, *rates)
    parts = np.concatenate(
        [resampler.process(part) for part in np.split(signal, sorted(cuts), axis=1)], axis=1
    )
    assert np.allclose(whole, parts, atol=1e-12)


def test_samples_go_to_the_channels_of_their_actuators_with_the_calibrations_gain():
    device = profile("dualsense-pcm")
    swapped = replace(device, actuators=device.actuators[::-1])
    family = device.family
    actuation = SampleActuation(swapped.actuators, family.channels, family.rate, family.rate)
    actuation.calibrate({"left grip": Calibration(gain=0.5)})
    played = actuation.process(np.array([[0.1, 0.2], [0.6, 0.8]]))
    a = np.exp(-2 * np.pi * 1.0 / family.rate)  # a high-pass of first order at 1 Hz
    np.testing.assert_allclose(
        played, lfilter([a, -a], [1, -a], [[0.3, 0.4], [0.1, 0.2]]), atol=1e-12
    )


@pytest.mark.parametrize("cuts", [(), (1, 700, 701), (20_000,)])
def test_a_steady_push_goes_to_no_actuator_and_vibration_passes(cuts):
    """Against SciPy's filter of first order, however the signal is cut; a blow keeps its energy,
    and a tone of 20 Hz its level."""
    rate = 8000
    time = np.arange(4 * rate) / rate
    # Half a cycle: a push of 10 ms.
    blow = np.where(time < 0.01, np.sin(2 * np.pi * 50 * time), 0.0)
    signals = np.array([np.full(len(time), 0.3), blow, np.sin(2 * np.pi * 20 * time)])
    high_pass = HighPass(3, rate)
    played = np.concatenate(
        [high_pass.process(part) for part in np.split(signals, cuts, axis=1)], axis=1
    )
    a = np.exp(-2 * np.pi / rate)
    np.testing.assert_allclose(played, lfilter([a, -a], [1, -a], signals), atol=1e-12)
    assert np.abs(played[0, 2 * rate :]).max() < 2e-6
    energies = 10 * np.log10((played[1:] ** 2).sum(axis=1) / (signals[1:] ** 2).sum(axis=1))
    assert energies[0] == pytest.approx(0, abs=0.15) and energies[1] == pytest.approx(0, abs=0.02)
    high_pass.reset()
    assert not high_pass.process(np.zeros((3, 10))).any()


@pytest.mark.parametrize(
    ("block", "message"),
    [
        (np.zeros((3, 4)), r"block has the shape \(3, 4\), not \(2, n\)"),
        (np.zeros(4), r"block has the shape \(4,\), not \(2, n\)"),
        (np.array([[0.0], [math.nan]]), "not finite"),
        (np.array([[math.inf], [0.0]]), "not finite"),
    ],
)
def test_blocks_of_another_shape_or_not_finite_are_refused(block, message):
    with pytest.raises(ValueError, match=message):
        checked_block(block, 2)
