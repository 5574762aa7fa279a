"""The streaming resampler against scipy.signal.resample, which is exact for periodic signals."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.signal
from haptic_tracing.core.devices.resampling import Resampler

RATES = [
    (8000, 1000), (8000, 1200), (8000, 1500), (8000, 2000), (8000, 3000), (8000, 4000), (8000, 11_025), (8000, 44_100), (8000, 48_000),
    (44_100, 8000), (48_000, 8000), (48_000, 1000), (3000, 8000), (4000, 48_000), (1000, 8000), (8000, 500), (8000, 200),
]  # fmt: skip


def spectra(
    rate_in: int, rate_out: int, highest: float | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Return the output's frequencies, its spectrum without its delay, that of SciPy's, and the
    delay, for periodic noise.

    highest: hertz above which the noise has nothing; None for white noise.
    """
    ratio = rate_out / rate_in
    period = (
        rate_in
        // np.gcd(rate_in, rate_out)
        * int(np.ceil(4000 / rate_in * np.gcd(rate_in, rate_out)))
    )
    # All equally strong, of random phases.
    tones = np.exp(2j * np.pi * np.random.default_rng(0).random(period // 2 + 1))
    noise = np.fft.irfft(
        tones * (np.fft.rfftfreq(period, 1 / rate_in) <= (highest or rate_in)), period
    )
    resampler = Resampler(1, rate_in, rate_out)
    before = int(np.ceil(0.4 * rate_in / period))  # periods until the filter has settled
    count = round(period * ratio)
    output = resampler.process(np.tile(noise, before + 2)[None])[0][before * count :][:count]
    frequency = np.fft.rfftfreq(count, 1 / rate_out)
    ours = np.fft.rfft(output) * np.exp(2j * np.pi * frequency * resampler.delay)
    return frequency, ours, np.fft.rfft(scipy.signal.resample(noise, count)), resampler.delay


def decibels(part: np.ndarray, whole: np.ndarray) -> float:
    return float(10 * np.log10((np.abs(part) ** 2).sum() / (np.abs(whole) ** 2).sum()))


@pytest.mark.parametrize(("rate_in", "rate_out"), RATES)
def test_as_scipy_to_85_decibels_up_to_four_fifths_of_the_lower_nyquist_frequency(
    rate_in: int, rate_out: int
) -> None:
    """With white noise, so that nothing comes back from above the Nyquist frequency either."""
    frequency, ours, reference, delay = spectra(rate_in, rate_out)
    low = frequency <= 0.4 * min(rate_in, rate_out)
    assert decibels((ours - reference)[low], reference[low]) < -85
    assert delay <= 7.8 / min(rate_in, rate_out)
    assert delay < 0.008 or min(rate_in, rate_out) < 1000


@pytest.mark.parametrize(("rate_in", "rate_out"), RATES)
def test_each_tone_of_the_pass_band_is_as_scipys_to_85_decibels(
    rate_in: int, rate_out: int
) -> None:
    lower = min(rate_in, rate_out)
    frequency, ours, reference, _ = spectra(rate_in, rate_out, 0.4 * lower)
    low = (frequency > 0) & (frequency <= 0.4 * lower)
    assert 20 * np.log10((np.abs(ours - reference)[low] / np.abs(reference[low])).max()) < -85
    images = frequency > 0.6 * lower
    assert not images.any() or decibels(ours[images], reference) < -85


def test_between_the_bands_the_response_stays_small() -> None:
    frequency, ours, reference, _ = spectra(8000, 16_000)
    between = (frequency > 3200) & (frequency < 4000)
    assert np.abs(ours[between] / reference[between]).max() < 10 ** (5 / 20)


def test_a_steady_value_stays_to_the_last_digits() -> None:
    for rate_in, rate_out in RATES:
        output = Resampler(1, rate_in, rate_out).process(np.ones((1, rate_in)))[0]
        assert np.abs(output[len(output) // 2 :] - 1.0).max() < 1e-12
