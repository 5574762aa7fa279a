"""One amplitude and one frequency over time, for formats without waves."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray, IntArray
from .carrier import Carrier
from .fitting import Band, Fit, fit_bands, needed_keys

WHOLE = Band(5, 700, 2.5, 90, 1600)
"""The frequencies that skin feels as one band."""
SETTLING = 0.05
"""Time (seconds) in which a carrier that directly follows another one gets into phase."""


def single_carrier(samples: NDArray[np.floating], sample_rate: int, fit: Fit) -> Carrier:
    """The samples (n,), n >= 1, as one oscillation of phase 0 at time 0, with amplitude 0 in silence."""
    return joined(fit_bands(samples, sample_rate, [WHOLE], fit)[0], len(samples) / sample_rate, fit)


def joined(carriers: Sequence[Carrier], duration: float, fit: Fit) -> Carrier:
    """One carrier in place of consecutive ones; the frequency in the gaps is such that the next one starts in phase."""
    amplitude_keys = [np.array([[0.0], [0.0]])]
    frequency_keys = [np.array([[0.0], [float(carriers[0].frequencies[0]) if carriers else fit.lowest]])]
    cycles = end = 0.0
    for carrier in carriers:
        begin = carrier.start if carrier.start > end else end + min(SETTLING, (carrier.end - end) / 2)
        local = begin - carrier.start
        passed, total = carrier.cycles(np.array([local, carrier.end - carrier.start]))
        before, after = float(frequency_keys[-1][1, -1]), float(np.interp(local, carrier.frequency_times, carrier.frequencies))
        middle = _between(before, after, begin - end, carrier.phase / (2 * math.pi) + float(passed) - cycles, fit)
        cycles += (begin - end) / 4 * (before + 2 * middle + after) + float(total - passed)
        later = (carrier.frequency_times > local) & (carrier.frequency_times < carrier.end - carrier.start)
        frequency_keys.append(np.array([[end, (end + begin) / 2, begin], [before, middle, after]]))
        frequency_keys.append(np.array([carrier.frequency_times[later] + carrier.start, carrier.frequencies[later]]))
        last = float(np.interp(carrier.end - carrier.start, carrier.frequency_times, carrier.frequencies))
        frequency_keys.append(np.array([[carrier.end], [last]]))
        inside = carrier.amplitude_times < carrier.end - carrier.start
        levels = carrier.amplitudes[inside].copy()
        levels[0] *= carrier.start <= end
        amplitude_keys.append(np.array([carrier.amplitude_times[inside] + carrier.start, levels]))
        amplitude_keys.append(np.array([[carrier.end], [carrier.amplitudes[-1] if carrier.end >= duration else 0.0]]))
        end = carrier.end
    amplitude_keys.append(np.array([[duration], [float(amplitude_keys[-1][1, -1])]]))
    return Carrier(0.0, duration, 0.0, *_cleaned(amplitude_keys, 1e-6), *_cleaned(frequency_keys, 1e-9))


def _between(before: float, after: float, gap: float, cycles: float, fit: Fit) -> float:
    """The frequency in the middle of a gap of ``gap`` seconds that makes it last ``cycles``, up to whole cycles."""
    if gap <= 0:
        return after
    near = gap / 2 * (before + after)
    for whole in (0, 1, -1):
        wanted = cycles + round(near - cycles) + whole
        middle = (4 * wanted / gap - before - after) / 2
        if fit.lowest <= middle <= fit.highest:
            return middle
    return (before + after) / 2


def _cleaned(keys: Sequence[FloatArray], tolerance: float) -> tuple[FloatArray, FloatArray]:
    """Times and values of the keys without redundant ones; the last of several at one time."""
    times, values = np.concatenate(keys, axis=1)
    last = np.append(np.diff(times) > 1e-9, True)
    times, values = times[last], values[last]
    kept = needed_keys(times, values, np.full(len(times), tolerance))
    return times[kept], values[kept]


def coarse_envelope(samples: NDArray[np.floating], sample_rate: int, step: float) -> tuple[FloatArray, FloatArray]:
    """Amplitude and frequency (hertz) every ``step`` seconds: of the sine with the same power and the same power of first differences.

    Each value covers its step and the step before, so that quick blows merge; none covers the step after, so that nothing comes early.
    The first difference of a sine of frequency f has 4 sin²(π f / rate) times its power.
    """
    count = max(math.ceil(len(samples) / sample_rate / step - 1e-9), 1)
    borders = np.minimum(np.round(np.arange(count + 1) * step * sample_rate).astype(np.int64), len(samples))
    values = np.append(samples.astype(np.float64), 0.0)
    power = _block_sums(values[:-1] ** 2, borders)
    change = _block_sums(np.diff(values[: len(samples)], append=values[len(samples) - 1 : len(samples)]) ** 2, borders)
    power[1:], change[1:] = power[1:] + power[:-1], change[1:] + change[:-1]
    width = np.maximum(np.diff(borders), 1)
    width[1:] = width[1:] + width[:-1]
    amplitude = np.sqrt(2 * power / width)
    ratio = np.divide(change, 4 * power, out=np.zeros(count), where=power > 0)
    return amplitude, np.asarray(sample_rate / math.pi * np.arcsin(np.sqrt(np.minimum(ratio, 1.0))))


def _block_sums(values: FloatArray, borders: IntArray) -> FloatArray:
    sums = np.concatenate([[0.0], np.cumsum(values)])
    return np.asarray(np.maximum(sums[borders[1:]] - sums[borders[:-1]], 0.0))
