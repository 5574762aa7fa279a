"""Oscillators against their formulas, numerical averages and scipy.signal's waves."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.integrate
import scipy.signal
from haptic_tracing.core.signals import (
    Automation,
    Oscillator,
    Pulse,
    Saw,
    Sine,
    Square,
    Triangle,
    ramp,
)
from mpmath import mp

RATE = 8000.0


def wave_of(oscillator: Oscillator, cycles: np.ndarray) -> np.ndarray:
    """The wave itself, without averaging, by SciPy where it has it."""
    angle = 2 * np.pi * cycles
    if isinstance(oscillator, Square):
        return scipy.signal.square(angle)
    if isinstance(oscillator, Saw):
        return scipy.signal.sawtooth(angle)
    if isinstance(oscillator, Triangle):
        return scipy.signal.sawtooth(angle + np.pi / 2, width=0.5)
    if isinstance(oscillator, Pulse):
        return (scipy.signal.square(angle, duty=oscillator.duty) + 1) / 2
    return np.sin(angle)


def test_sine_is_exact_half_an_hour_later() -> None:
    start = 30 * 60 * 8000
    mp.dps = 40
    exact = [float(mp.sin(2 * mp.pi * mp.mpf(61.7) * (start + n) / 8000)) for n in range(50)]
    assert np.abs(Sine(61.7).sample(start, 50, RATE) - exact).max() < 1e-9


def test_sine_with_amplitude_and_phase() -> None:
    times = np.arange(4000) / RATE
    expected = 0.3 * np.sin(2 * np.pi * (123.4 * times + 0.2))
    assert np.abs(Sine(123.4, 0.3, 0.2).sample(0, 4000, RATE) - expected).max() < 1e-12


def test_onset_between_samples_is_exact() -> None:
    onset = 0.0123456789
    times = np.arange(4000) / RATE
    expected = np.where(times >= onset, np.sin(2 * np.pi * 250 * (times - onset)), 0.0)
    assert np.abs(Sine(250.0).sample(0, 4000, RATE, onset) - expected).max() < 1e-12


def test_ramped_frequency_is_a_linear_chirp() -> None:
    times = np.arange(8000) / RATE
    expected = scipy.signal.chirp(times, f0=20.0, t1=1.0, f1=400.0, method="linear", phi=-90)
    assert np.abs(Sine(ramp(20.0, 400.0, 1.0)).sample(0, 8000, RATE) - expected).max() < 1e-10


def test_keyed_frequency_integrates_the_keys() -> None:
    keys = Automation((0.1, 0.25, 0.25, 0.6), (50.0, 90.0, 200.0, 30.0))
    times = np.arange(8000) / RATE

    def frequency(t: float) -> float:
        if t < 0.25:
            return float(np.interp(t, (0.1, 0.25), (50.0, 90.0)))
        return float(np.interp(t, (0.25, 0.6), (200.0, 30.0)))

    for n in (500, 1600, 2500, 4500, 7999):
        cycles, _ = scipy.integrate.quad(
            frequency, 0.0, times[n], points=[0.1, 0.25, 0.6], limit=200
        )
        assert Sine(keys).sample(n, 1, RATE)[0] == pytest.approx(
            np.sin(2 * np.pi * cycles), abs=1e-9
        )


def test_keyed_amplitude() -> None:
    keys = Automation((0.0, 0.5), (0.0, 1.0))
    times = np.arange(8000) / RATE
    expected = np.interp(times, (0.0, 0.5), (0.0, 1.0)) * np.sin(2 * np.pi * 60 * times)
    assert np.abs(Sine(60.0, keys).sample(0, 8000, RATE) - expected).max() < 1e-12


@pytest.mark.parametrize(
    "oscillator",
    [Square(97.0), Saw(97.0), Triangle(97.0), Pulse(97.0, duty=0.1), Pulse(97.0, duty=0.6)],
)
def test_waves_are_scipys_away_from_edges(oscillator: Oscillator) -> None:
    cycles = 97.0 * np.arange(8000) / RATE
    edges = {
        Square: (0.0, 0.5),
        Saw: (0.0,),
        Triangle: (0.25, 0.75),
        Pulse: (0.0, getattr(oscillator, "duty", 0.0)),
    }[type(oscillator)]
    far = np.ones(8000, dtype=bool)
    for edge in edges:
        far &= np.abs((cycles - edge + 0.5) % 1.0 - 0.5) > 97.0 / RATE
    assert far.sum() > 6000
    assert np.abs(oscillator.sample(0, 8000, RATE) - wave_of(oscillator, cycles))[far].max() < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("frequency", [3.0, 61.0, 333.0, 1999.0, 3900.0])
@pytest.mark.parametrize(
    "kind", [Square(), Saw(), Triangle(), Pulse(duty=0.03), Pulse(duty=0.5), Pulse(duty=0.97)]
)
def test_waves_are_averaged_over_the_sample_period(kind: Oscillator, frequency: float) -> None:
    oscillator = (
        type(kind)(frequency, duty=kind.duty) if isinstance(kind, Pulse) else type(kind)(frequency)
    )
    width = frequency / RATE
    fine = (np.arange(20_000) + 0.5) / 20_000 - 0.5
    numbers = np.arange(200)
    averages = [wave_of(oscillator, frequency * n / RATE + fine * width).mean() for n in numbers]
    assert np.abs(oscillator.sample(0, 200, RATE) - averages).max() < 2e-4


def test_aliases_of_a_square_stay_out_of_what_skin_feels() -> None:
    count = 1 << 16
    frequency = 61.0
    spectrum = np.abs(np.fft.rfft(Square(frequency).sample(0, count, RATE) * np.hanning(count))) / (
        count / 4
    )
    bins = np.arange(len(spectrum)) * RATE / count
    between_harmonics = np.abs(bins / frequency % 2 - 1) * frequency > 4.0
    assert 20 * np.log10(spectrum[between_harmonics & (bins < 250.0)].max()) < -68
    assert 20 * np.log10(spectrum[between_harmonics & (bins < 1000.0)].max()) < -56


@pytest.mark.parametrize("cls", [Sine, Square, Saw, Triangle, Pulse])
def test_silent_where_the_rate_cannot_carry_the_frequency(cls: type[Oscillator]) -> None:
    assert not cls(4000.0).sample(0, 100, RATE).any()
    sweep = cls(ramp(100.0, 8000.0, 1.0)).sample(0, 8000, RATE)
    carried = 100.0 + 7900.0 * np.arange(8000) / RATE < 4000.0
    assert not sweep[~carried].any()
    assert sweep[carried].any()


@pytest.mark.parametrize("cls", [Sine, Square, Saw, Triangle, Pulse])
def test_frequency_zero_is_constant(cls: type[Oscillator]) -> None:
    samples = cls(0.0, phase=0.05).sample(0, 100, RATE)
    assert (samples == samples[0]).all()
    assert samples[0] == pytest.approx(wave_of(cls(), np.array([0.05]))[0], abs=1e-6)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"frequency": -1.0}, "frequency"),
        ({"frequency": 1e9}, "frequency"),
        ({"frequency": float("nan")}, "frequency"),
        ({"frequency": "60"}, "frequency"),
        ({"frequency": True}, "frequency"),
        ({"frequency": ramp(1.0, 1e6, 1.0)}, "frequency"),
        ({"amplitude": float("inf")}, "amplitude"),
        ({"amplitude": 10**400}, "amplitude"),
        ({"phase": None}, "phase"),
    ],
)
def test_bad_arguments_are_named(arguments: dict[str, object], name: str) -> None:
    with pytest.raises(ValueError, match=f"^{name}: "):
        Sine(**arguments)  # type: ignore[arg-type]
