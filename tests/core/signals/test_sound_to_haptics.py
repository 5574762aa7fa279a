"""Sounds as vibration, against SciPy and against sounds whose events we put there ourselves."""

import json
from itertools import pairwise

import numpy as np
import pytest
from haptic_tracing.core.signals import signal_from_dict
from haptic_tracing.core.signals.felt_sound import (
    Feel,
    amplitudes,
    felt_onsets,
    frequencies,
    vibration,
)
from haptic_tracing.core.signals.sound import HOP, RATE, Clip, Heard, heard, mixed, outcome
from made_sounds import SOUNDS
from scipy.signal import chirp, hilbert, stft


class Held:
    """A recording in memory."""

    def __init__(self, samples, rate):
        self._samples, self.rate, self.count = (
            np.asarray(samples, dtype=float).reshape(len(samples), -1),
            float(rate),
            len(samples),
        )

    def read(self, first, last):
        return self._samples[first:last]


def listen(samples, rate=RATE, **clip) -> Heard:
    return outcome(heard(outcome(mixed((Clip(Held(samples, rate), **clip),)))))


@pytest.fixture(scope="module")
def ten():
    """What is heard in each of the ten sounds, and its onsets."""
    return {make.__name__: (listen(*sound[:2]), sound[2]) for make in SOUNDS for sound in (make(),)}


@pytest.mark.slow
def test_onsets_lie_within_ten_milliseconds_and_none_is_missed(ten, capsys):
    false = {}
    for name, (sound, true) in ten.items():
        found, _ = felt_onsets(sound, Feel())
        off = np.abs(found[:, None] - true)
        assert off.min(axis=0).max() <= 0.010, name
        false[name] = int((off.min(axis=1) > 0.010).sum())
    with capsys.disabled():
        print(
            f"\nonsets where there are none: {sum(false.values())} beside "
            f"{sum(len(true) for _, true in ten.values())}: {false}"
        )
    assert sum(false.values()) <= 0.05 * sum(len(true) for _, true in ten.values())


def test_the_level_is_hilberts_envelope():
    """Its root mean square over 10 ms, as SciPy computes it of the whole sound at once."""
    rng = np.random.default_rng(11)
    t = np.arange(3 * RATE) / RATE
    sound = (0.5 + 0.4 * np.sin(2 * np.pi * 3 * t)) * np.sin(2 * np.pi * 90 * t) + rng.normal(
        0, 0.05, len(t)
    )
    power = np.abs(hilbert(sound)) ** 2
    times = np.arange(20, 580)
    expected = [np.sqrt(power[k * 80 - 80 : k * 80 + 80].mean()) for k in times]
    assert listen(sound).levels[times] == pytest.approx(expected, rel=0.01)


def test_levels_do_not_depend_on_where_blocks_begin():
    """A sine over three blocks of 8 seconds has one level throughout, whatever its frequency and
    offset."""
    t = np.arange(20 * RATE) / RATE
    for frequency in (25.0, 440.0, 5000.0):
        levels = listen(0.3 * np.sin(2 * np.pi * frequency * t) + 0.1).levels
        assert levels[100:-100] == pytest.approx(0.3, rel=0.01)


def test_the_flux_is_that_of_scipys_spectrogram():
    from haptic_tracing.core.signals import onsets

    rng = np.random.default_rng(12)
    sound = rng.normal(0, 0.1, RATE)
    frames = np.lib.stride_tricks.sliding_window_view(sound, onsets.FRAME)[::80]
    _, _, spectra = stft(
        sound, window="hann", nperseg=320, noverlap=240, boundary=None, padded=False
    )
    edges = [*onsets._BINS, 160]
    bands = np.array(
        [np.sqrt((np.abs(2 * spectra[low:high]) ** 2).sum(axis=0)) for low, high in pairwise(edges)]
    )
    levels = np.log10(1 + 1e4 * bands.T)
    assert onsets.band_levels(frames) == pytest.approx(levels, abs=1e-9)
    padded = np.pad(levels, ((0, 0), (1, 1)), mode="edge")
    expected = [
        np.mean([max(now[b] - max(padded[k, b : b + 3]), 0) for b in range(levels.shape[1])])
        for k, now in enumerate(levels[2:])
    ]
    assert onsets.flux(levels) == pytest.approx(expected)


@pytest.mark.parametrize("method", ["linear", "logarithmic"])
def test_the_carrier_follows_the_pitch_of_a_sweep_within_5_percent(method):
    t = np.arange(10 * 44100) / 44100
    sound = listen(0.5 * chirp(t, 50, 10, 380, method=method), 44100)
    times = np.arange(0.1, 9.9, HOP)
    pitch = 50 + 33 * times if method == "linear" else 50 * (380 / 50) ** (times / 10)
    signal = vibration(sound, Feel(pitch=True, bursts=0.0))
    _, carrier = signal.of
    assert carrier.frequency.at(times) == pytest.approx(pitch, rel=0.05)


def test_a_missing_fundamental_is_the_pitch_and_high_pitches_come_down_by_octaves():
    t = np.arange(2 * RATE) / RATE
    buzz = sum(np.sin(2 * np.pi * k * 110 * t) for k in (2, 3, 4, 5)) / 8
    assert frequencies(listen(buzz), Feel(pitch=True))[50:350] == pytest.approx(110, rel=0.01)
    whistle = listen(0.5 * np.sin(2 * np.pi * 1500 * t))
    assert frequencies(whistle, Feel(pitch=True))[50:350] == pytest.approx(375, rel=0.01)
    hum = listen(0.5 * np.sin(2 * np.pi * 45 * t))
    assert frequencies(hum, Feel(pitch=True, band=(80.0, 200.0)))[50:350] == pytest.approx(
        90, rel=0.01
    )


def test_noise_without_pitch_has_the_frequency_that_was_chosen():
    noise = np.random.default_rng(13).normal(0, 0.1, 2 * RATE)
    assert (frequencies(listen(noise), Feel(frequency=123.0, pitch=True)) == 123.0).all()


def test_a_fixed_carrier_is_exact():
    t = np.arange(2 * 48000) / 48000
    signal = vibration(
        listen(0.5 * np.sin(2 * np.pi * 700 * t), 48000), Feel(frequency=187.5, bursts=0.0)
    )
    spectrum = np.abs(np.fft.rfft(signal.sample(0, 16000, 8000.0) * np.hanning(16000)))
    assert np.fft.rfftfreq(16000, 1 / 8000)[spectrum.argmax()] == 187.5
    assert signal.of[1].frequency == 187.5


def test_what_is_below_the_gate_makes_nothing_and_gain_multiplies():
    t = np.arange(3 * RATE) / RATE
    sound = listen(np.where(t < 1, 0.2, np.where(t < 2, 0.05, 0.2)) * np.sin(2 * np.pi * 200 * t))
    levels = amplitudes(sound, Feel(gate=-20.0, gain=2.0, release=0.001, bursts=0.0))
    assert levels[20:180] == pytest.approx(0.4, rel=0.01)  # -14 dB
    assert (levels[220:380] == 0).all()  # -26 dB
    assert amplitudes(sound, Feel(gain=100.0))[20:180] == pytest.approx(1.0)
    with pytest.raises(ValueError, match="louder than the gate"):
        vibration(sound, Feel(gate=-10.0))


def test_the_amplitude_falls_by_the_release_time_and_rises_at_once():
    sound = Heard(
        1.0, np.where(np.arange(201) == 100, 0.5, 0.0), np.zeros(201), np.zeros(0), np.zeros(0)
    )
    levels = amplitudes(sound, Feel(release=0.1, gate=-80.0))
    assert levels[99] == 0.0
    assert levels[100:] == pytest.approx(0.5 * np.exp(-np.arange(101) * HOP / 0.1))


@pytest.mark.slow
def test_every_onset_is_a_burst_of_two_cycles_from_phase_zero(ten):
    for name in ("claps", "rain", "drums"):
        sound, _ = ten[name]
        feel = Feel(frequency=200.0)
        times, strengths = felt_onsets(sound, feel)
        bursts = vibration(sound, feel).of[1]
        played = bursts.sample(0, round(sound.seconds * 48000), 48000.0)
        expected = np.zeros(len(played))
        for time, strength in zip(times, strengths, strict=True):
            since = np.arange(len(played)) / 48000 - time
            expected += np.where(
                (since >= 0) & (since < 0.01), strength * np.sin(2 * np.pi * 200 * since), 0.0
            )
        assert np.abs(played - expected).max() < 2e-3, name


@pytest.mark.slow
def test_the_vibration_is_the_same_every_time_and_survives_json(ten):
    for sound, _ in ten.values():
        for feel in (Feel(), Feel(pitch=True)):
            signal = vibration(sound, feel)
            assert signal == vibration(sound, feel)
            form = json.dumps(signal.to_dict())
            assert signal_from_dict(json.loads(form)) == signal
            assert signal.duration == pytest.approx(sound.seconds, abs=0.011)
            rendered = signal.sample(0, round(signal.duration * 8000), 8000.0)
            assert np.isfinite(rendered).all()
            # Keys are left out where that changes the amplitude by less.
            assert np.abs(rendered).max() <= 1.03


def test_clips_play_at_their_time_speed_and_volume():
    """A click at 0.5 s of a recording of 2 s: cut, played at double speed, half as loud, over
    another one."""
    click = np.zeros((96000, 2))
    click[24000] = 1.0
    at = {
        "plain": {},
        "later": {"start": 1.0},
        "cut": {"skip": 0.25},
        "within": {"start": -0.25},
        "fast": {"speed": 2.0},
    }
    places = {"plain": 0.5, "later": 1.5, "cut": 0.25, "within": 0.25, "fast": 0.25}
    for name, clip in at.items():
        samples = outcome(mixed((Clip(Held(click, 48000), **clip),)))
        assert np.argmax(samples) / RATE == pytest.approx(places[name], abs=1e-4), name
    assert not outcome(
        mixed(
            (Clip(Held(click, 48000), volume=0.5), Clip(Held(np.ones(480), 48000), seconds=0.001))
        )
    )[9000:].any()
    loud = outcome(mixed((Clip(Held(click, 48000)),)))
    both = outcome(
        mixed((Clip(Held(click, 48000), volume=0.5), Clip(Held(click, 48000), volume=0.25)))
    )
    np.testing.assert_allclose(both, 0.75 * loud, rtol=0, atol=1e-6)


@pytest.mark.parametrize("rate", [8000, 11025, 22050, 44100, 48000, 96000])
def test_any_rate_is_heard_alike(rate):
    t = np.arange(2 * rate) / rate
    sound = listen(0.5 * np.sin(2 * np.pi * 300 * t) * (t > 0.7), rate)
    assert sound.seconds == pytest.approx(2.0, abs=1e-3)
    assert sound.onsets == pytest.approx([0.7], abs=0.010)
    assert sound.levels[200:380] == pytest.approx(0.5, rel=0.01)


@pytest.mark.parametrize(
    ("samples", "fault"),
    [
        (np.zeros(1000), "silent"),
        (np.full(1000, np.nan), "not finite"),
        (np.full(1000, np.inf), "not finite"),
    ],
)
def test_what_is_wrong_with_a_sound_is_said(samples, fault):
    with pytest.raises(ValueError, match=fault):
        listen(samples)


@pytest.mark.parametrize("rate", [0.001, 1.0, 999.0, 4e9])
def test_rates_that_no_sound_has_are_refused(rate):
    with pytest.raises(ValueError, match="samples a second"):
        listen(np.ones(1000), rate)


def test_longer_than_half_an_hour_is_refused_before_anything_is_read():
    recording = Held(np.zeros(10), 16000)
    recording.count = 1801 * 16000
    with pytest.raises(ValueError, match="30 minutes"):
        outcome(mixed((Clip(recording),)))
