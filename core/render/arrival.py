"""Amplitudes with which sources arrive at listeners, as they are rendered."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..perception import FullScale, lowest_threshold, threshold_level
from ..propagation.result import Propagation
from ..scene.bands import BAND_COUNT
from ..scene.values import Listener, Source
from ..signals import Automation, Signal
from .filter_bank import bank_spectra
from .renderer import SAMPLE_RATE
from .voices import steady_tone

_RATE = 2000
"""Samples of the first second of a signal: enough for the frequencies of all bands."""

UNFELT = 20.0
"""What lies so far [dB] under its listener's threshold of feeling is not rendered."""


def signal_gains(sources: Sequence[Source], propagation: Propagation) -> FloatArray:
    """Gain (s, l) of each source's signal on its paths to each listener. Where functions use bands,
    that is the RMS gain of the signal's first second through their filters; of a tone, its gain."""
    if propagation.band_gain is None:
        return propagation.gain
    gain = propagation.band_gain
    power = np.array([_band_power(source.emitted) for source in sources])
    squared = ((gain @ power.reshape(-1, BAND_COUNT, BAND_COUNT)) * gain).sum(axis=2)
    return np.asarray(np.sqrt(np.maximum(squared, 0.0)))


def arriving(sources: Sequence[Source], propagation: Propagation) -> FloatArray:
    """Amplitude (s, l) of each source at each listener: its own times the gain of its signal."""
    amplitude = np.array([source.amplitude for source in sources]).reshape(-1, 1)
    return np.asarray(signal_gains(sources, propagation) * amplitude)


def are_unfelt(
    sources: Sequence[Source], listeners: Sequence[Listener], propagation: Propagation
) -> BoolArray:
    """Which sources (s, l) lie more than `UNFELT` under the threshold of feeling of a listener: a
    steady tone by its level; any other signal if even a tone as strong as its peak would, in the
    band that arrives best and at the frequency that is felt best."""
    frequencies = [_tone_frequency(source.emitted) for source in sources]
    gain = propagation.gain
    if propagation.band_gain is not None:
        gain = propagation.band_gain.max(axis=2)
        is_tone = np.array([frequency is not None for frequency in frequencies])[:, None]
        if is_tone.any():
            gain = np.where(is_tone, signal_gains(sources, propagation), gain)
    peak = np.array([source.amplitude * source.emitted.peak for source in sources]).reshape(-1, 1)
    thresholds = {
        device: [_threshold(frequency, device) for frequency in frequencies]
        for device in {item.device for item in listeners}
    }
    threshold = np.array([thresholds[item.device] for item in listeners]).reshape(gain.shape[::-1])
    factor = np.array([item.gain for item in listeners])
    return np.asarray(gain * peak * factor < 10 ** ((threshold.T - UNFELT) / 20))


def _tone_frequency(signal: Signal) -> float | None:
    """That of a steady tone [Hz]; None for another signal."""
    tone = steady_tone(signal, SAMPLE_RATE)
    return None if tone is None or isinstance(tone.frequency, Automation) else tone.frequency


@lru_cache(maxsize=1024)
def _threshold(frequency: float | None, device: FullScale | None) -> float:
    """That of feeling a tone, by default the lowest one [dB of full scale]."""
    if frequency is None:
        return lowest_threshold(device)
    return float(threshold_level(max(frequency, 1.0), device))


@lru_cache(maxsize=256)
def _band_power(signal: Signal) -> FloatArray:
    """Mean products (bands, bands) of the signal's parts in two bands each, relative to its mean
    power, without its steady part; silence counts as a tone in the lowest band."""
    spectrum = np.abs(np.fft.rfft(signal.sample(0, _RATE, _RATE))) ** 2
    spectrum[0] = 0.0
    spectrum[1:-1] *= 2.0
    total = spectrum.sum()
    if not total:
        return np.diag(np.eye(BAND_COUNT)[0])
    power = (_products() * spectrum).sum(axis=-1) / total
    power.setflags(write=False)
    return np.asarray(power)


@lru_cache(maxsize=1)
def _products() -> FloatArray:
    """Products (bands, bands, f) of the filter responses of each two bands, at f = 0, 1, 2, ...
    hertz."""
    response = bank_spectra(SAMPLE_RATE, round(SAMPLE_RATE))[:, : _RATE // 2 + 1]
    return response[:, None] * response
