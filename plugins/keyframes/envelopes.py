"""One amplitude and one frequency over time, for formats without waves."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...core.arrays import FloatArray, IntArray
from ...core.formats.tracks.listener_tracks import CHUNK, PIECE, Row
from ...core.signals.keys import needed_keys
from .analytic import Band
from .carrier import Carrier
from .comparison import Comparison
from .fitting import Fit, fit_bands
from .onsets import RATE, away_from, pulses

WHOLE = Band(5, 700, 2.5, 90, 1600)
"""The tactile frequencies as one band."""
SETTLING = 0.05
"""Time (seconds) in which a carrier that directly follows another one gets into phase."""
SHORTEST_STEP = 0.0125
"""Minimum time between the keys of a thinned carrier (seconds): published files have at most 81 a
second."""
STEADY_SECONDS = 0.5
"""Time over which the steady part of a vibration is the mean of its samples."""
FINEST = 0.005
"""Tolerance of a thinned carrier, relative to the largest value."""
SILENCE = 0.002
"""Amplitude that counts as silence, relative to the largest."""
IN_PHASE = 0.02
"""Phase difference (cycles) within which a carrier follows another one without delay."""


class Burst(NamedTuple):
    """A short vibration of constant ``amplitude`` that stands for an impact or a pulse.

    time, seconds: when it begins, and how long it is. frequency: hertz. share: that of the power of
    the samples while it sounds, without their steady part, which it has.
    """

    time: float
    seconds: float
    frequency: float
    amplitude: float
    share: float


def bursts_of(
    row: Row, impacts: FloatArray, form: Callable[[float], tuple[float, float]]
) -> list[Burst]:
    """A burst per impact, at most as strong as that, and per pulse, as those of a jackhammer, with
    at most the power of the samples while it sounds; of bursts that would overlap the strongest.

    form: seconds of a burst of a frequency, and the power of one of amplitude 1.
    """
    rate, (longest, _), (shortest, _) = row.sample_rate, form(0.0), form(math.inf)
    impacts = impacts[impacts[:, 0] < row.duration]
    times = _pulse_times(row, impacts[:, 0], longest, shortest)
    events = sorted([*impacts.tolist(), *([time, 1.0] for time in times.tolist())])
    found: list[Burst] = []
    for (time, strength), (after, _) in pairwise([*events, [row.duration, 0.0]]):
        first = math.ceil(time * rate)
        # From a little before on: the edge with which a pulse begins belongs to it.
        alone = max(min(longest, after - time), shortest)
        frequency = _frequency(row.read(first - _lag(rate), first + math.ceil(alone * rate)), rate)
        seconds, unit = form(frequency)
        felt = _felt_power(row, first, first + math.ceil(seconds * rate))
        amplitude = min(strength, math.sqrt(felt / unit))
        if amplitude <= 0:
            continue
        if found and time < found[-1].time + found[-1].seconds:
            if amplitude <= found[-1].amplitude:
                continue
            found.pop()
        found.append(Burst(time, seconds, frequency, amplitude, amplitude**2 * unit / felt))
    return found


def _pulse_times(row: Row, impacts: FloatArray, longest: float, apart: float) -> FloatArray:
    """Times (seconds) of pulses of at most ``longest`` seconds, impacts aside, that are at least
    ``apart`` seconds from any other: closer ones are a vibration."""
    power, _, width, _ = powers(row, 1 / RATE)
    times = away_from(pulses(power / width, longest), impacts) / RATE
    gaps = np.diff(times, prepend=-math.inf, append=math.inf)
    return np.asarray(times[np.minimum(gaps[1:], gaps[:-1]) >= apart])


def _felt_power(row: Row, first: int, last: int) -> float:
    """The mean square of samples, without the share that is steady around them."""
    reach = math.ceil(STEADY_SECONDS / 2 * row.sample_rate)
    around = row.read(first - reach, first + reach)
    steady = float(np.mean(around)) ** 2 / max(float(np.mean(around**2)), 1e-300)
    return float(np.mean(row.read(first, last) ** 2)) * (1 - steady)


class WithoutBursts(Row):
    """A row without the power of bursts, which takes the same share of every sample while they
    sound."""

    def __init__(self, row: Row, bursts: Sequence[Burst]) -> None:
        self._row, self.count, self.sample_rate = row, row.count, row.sample_rate
        self._starts = np.ceil([burst.time * row.sample_rate for burst in bursts]).astype(np.int64)
        self._bursts = bursts

    def read(self, first: int, last: int) -> FloatArray:
        samples = self._row.read(first, last)
        begin = max(int(np.searchsorted(self._starts, first)) - 1, 0)
        for start, burst in zip(self._starts[begin:].tolist(), self._bursts[begin:], strict=True):
            if start >= last:
                break
            end = start + math.ceil(burst.seconds * self.sample_rate)
            samples[max(start - first, 0) : max(end - first, 0)] *= math.sqrt(
                max(1 - burst.share, 0.0)
            )
        return samples


def single_carrier(row: Row, fit: Fit) -> Carrier:
    """The samples, at least one, as one oscillation of phase 0 at time 0, with amplitude 0 in
    silence."""
    return joined(
        (carrier for _, (carriers,) in fit_bands(row, [WHOLE], fit) for carrier in carriers),
        row.duration,
        fit,
    )


def thinned_carrier(row: Row, low: float, high: float, most: float) -> Carrier:
    """The vibration of a listener as a tone of changing amplitude and frequency.

    Keys are as many as ``most`` allows: the tolerance within which they are redundant is the least
    possible.

    Args:
        row: the samples.
        low: lowest frequency [Hz].
        high: highest frequency [Hz].
        most: keys per second, each of amplitude and frequency.
    """
    step = max(SHORTEST_STEP, 1 / most)
    amplitude, frequency = vibration_envelope(row, step)
    times = np.minimum((np.arange(len(amplitude)) + 0.5) * step, row.duration)
    times = np.concatenate([[0.0], times, [row.duration]])
    amplitude = np.minimum(np.pad(amplitude, 1, mode="edge"), 1.0)
    frequency = np.clip(np.pad(frequency, 1, mode="edge"), low, high)
    budget = max(math.floor(most * row.duration), 2)
    kept = _within_budget(times, amplitude, FINEST * float(np.max(amplitude)), budget)
    # Frequencies matter where there is an amplitude: the others take that of the last audible one.
    audible = np.maximum.accumulate(
        np.where(amplitude > SILENCE * np.max(amplitude), np.arange(len(amplitude)), 0)
    )
    keyed = _within_budget(times, frequency[audible], FINEST * (high - low), budget // 2)
    return Carrier(
        0.0,
        row.duration,
        0.0,
        times[kept],
        amplitude[kept],
        times[keyed],
        frequency[audible][keyed],
    )


def _within_budget(times: FloatArray, values: FloatArray, tolerance: float, most: int) -> IntArray:
    """The keys that remain at the smallest tolerance, doubled as often as necessary, with which
    they are at most ``most``."""
    kept = needed_keys(times, values, np.full(len(times), tolerance))
    while len(kept) > max(most, 2) and tolerance < np.ptp(values):
        tolerance *= 2
        kept = needed_keys(times, values, np.full(len(times), tolerance))
    return kept


def joined(carriers: Iterable[Carrier], duration: float, fit: Fit) -> Carrier:
    """One carrier in place of consecutive ones; the frequency in the gaps is such that the next one
    starts in phase."""
    amplitude_keys = [np.array([[0.0], [0.0]])]
    frequency_keys: list[FloatArray] = []
    cycles = end = 0.0
    for carrier in carriers:
        if not frequency_keys:
            frequency_keys.append(np.array([[0.0], [float(carrier.frequencies[0])]]))
        off = (carrier.phase / (2 * math.pi) - cycles + 0.5) % 1.0 - 0.5
        follows = carrier.start <= end and abs(off) > IN_PHASE
        begin = end + min(SETTLING, (carrier.end - end) / 2) if follows else max(carrier.start, end)
        local = begin - carrier.start
        passed, total = carrier.cycles(np.array([local, carrier.end - carrier.start]))
        before = float(frequency_keys[-1][1, -1])
        after = float(np.interp(local, carrier.frequency_times, carrier.frequencies))
        middle = _between(
            before, after, begin - end, carrier.phase / (2 * math.pi) + float(passed) - cycles, fit
        )
        cycles += (begin - end) / 4 * (before + 2 * middle + after) + float(total - passed)
        later = (carrier.frequency_times > local) & (
            carrier.frequency_times < carrier.end - carrier.start
        )
        frequency_keys.append(np.array([[end, (end + begin) / 2, begin], [before, middle, after]]))
        frequency_keys.append(
            np.array([carrier.frequency_times[later] + carrier.start, carrier.frequencies[later]])
        )
        last = float(
            np.interp(carrier.end - carrier.start, carrier.frequency_times, carrier.frequencies)
        )
        frequency_keys.append(np.array([[carrier.end], [last]]))
        inside = carrier.amplitude_times < carrier.end - carrier.start
        levels = carrier.amplitudes[inside].copy()
        levels[0] *= carrier.start <= end
        amplitude_keys.append(np.array([carrier.amplitude_times[inside] + carrier.start, levels]))
        amplitude_keys.append(
            np.array([[carrier.end], [carrier.amplitudes[-1] if carrier.end >= duration else 0.0]])
        )
        end = carrier.end
    amplitude_keys.append(np.array([[duration], [float(amplitude_keys[-1][1, -1])]]))
    frequency_keys = frequency_keys or [np.array([[0.0], [fit.lowest]])]
    return Carrier(
        0.0, duration, 0.0, *_cleaned(amplitude_keys, 1e-6), *_cleaned(frequency_keys, 1e-9)
    )


def _between(before: float, after: float, gap: float, cycles: float, fit: Fit) -> float:
    """The frequency [Hz] in the middle of the gap between two carriers with which the phase is
    right at its end: the signal makes the cycles wanted in it, or a whole number more or less. The
    frequency is linear from the beginning to the middle, and from there to the end.

    Args:
        before: frequency at its beginning [Hz].
        after: frequency at its end [Hz].
        gap: [s].
        cycles: wanted.
        fit: with the limits of frequencies.
    """
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
    times = times[last]
    values = values[last]
    kept = needed_keys(times, values, np.full(len(times), tolerance))
    return times[kept], values[kept]


def vibration_envelope(row: Row, step: float) -> tuple[FloatArray, FloatArray]:
    """Amplitude and frequency (hertz) every ``step`` seconds: of the sine with the same power and
    the same power of differences, without the steady part of the samples, a push that no motor can
    play.

    Each value covers its step and the step before, so that impacts in quick succession merge; none
    covers the step after, so that nothing is early.
    """
    power, change, width, total = powers(row, step)
    reach = np.ones(2 * math.ceil(STEADY_SECONDS / 2 / step) + 1)
    steady = (_spread(total, reach) / _spread(width, reach)) ** 2
    rest = np.maximum(power - width * steady, 0.0)
    both = [
        np.concatenate([values[:1], values[1:] + values[:-1]]) for values in (rest, change, width)
    ]
    amplitude = np.sqrt(2 * both[0] / both[2]).round(6)
    return amplitude, mean_frequency(both[0], both[1], row.sample_rate)


def _spread(values: FloatArray, reach: FloatArray) -> FloatArray:
    """The sums of each value and its neighbours."""
    return np.convolve(np.pad(values, len(reach) // 2), reach, "valid")


def compare_steps(listener: int, amplitudes: FloatArray, step: float, measured: Comparison) -> None:
    """Compare a listener's samples with ``amplitudes`` (n,), each of which holds for ``step``
    seconds."""
    count, thinning = measured.tracks.count, measured.thinning
    for first in range(0, count, CHUNK // thinning * thinning):
        end = min(first + CHUNK // thinning * thinning, count)
        times = np.arange(first, end, thinning) / measured.tracks.sample_rate
        measured.add(
            listener, amplitudes[np.minimum((times / step).astype(np.int64), len(amplitudes) - 1)]
        )


def powers(row: Row, step: float) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """In every ``step`` seconds the sums of the squared samples and of the squared differences over
    half a millisecond, the number of samples, their sum."""
    rate = row.sample_rate
    lag = _lag(row.sample_rate)
    count = max(math.ceil(row.count / rate / step - 1e-9), 1)
    borders = np.minimum(np.round(np.arange(count + 1) * step * rate).astype(np.int64), row.count)
    power = np.zeros(count)
    change = np.zeros(count)
    total = np.zeros(count)
    steps = max(round(PIECE / (step * rate)), 1)
    for first in range(0, count, steps):
        inside = borders[first : first + steps + 1]
        samples = row.read(int(inside[0]), int(inside[-1]) + lag)
        differences = samples[lag:] - samples[:-lag]
        if inside[-1] == row.count and len(differences) >= 2 * lag:
            differences[-lag:] = differences[-2 * lag : -lag]
        power[first : first + steps] = _block_sums(samples[:-lag] ** 2, inside - inside[0])
        change[first : first + steps] = _block_sums(differences**2, inside - inside[0])
        total[first : first + steps] = _block_sums(samples[:-lag], inside - inside[0])
    return power, change, np.maximum(np.diff(borders), 1).astype(np.float64), total


def mean_frequency(power: FloatArray, change: FloatArray, sample_rate: float) -> FloatArray:
    """Frequency (hertz) of the sine with this power and this power of differences over half a
    millisecond, 4 sin²(π f lag) times its own; 0 for silence. Above 1000 Hz, which nobody feels,
    there may be power without effect on it: the edges of pulses."""
    ratio = np.divide(change, 4 * power, out=np.zeros_like(power), where=power > 0)
    return sample_rate / _lag(sample_rate) / math.pi * np.arcsin(np.sqrt(np.minimum(ratio, 1.0)))


def _frequency(samples: FloatArray, sample_rate: int) -> float:
    """The mean frequency (hertz) of a few samples."""
    lag = _lag(sample_rate)
    changes = np.append(samples[lag:], np.zeros(lag)) - samples
    sums = np.array([[np.dot(samples, samples)], [np.dot(changes, changes)]])
    return float(mean_frequency(sums[0], sums[1], sample_rate)[0])


def _lag(sample_rate: float) -> int:
    """Samples of half a millisecond."""
    return max(round(sample_rate / 2000), 1)


def _block_sums(values: FloatArray, borders: IntArray) -> FloatArray:
    """The sums between neighbouring borders, the last of which is the end of the values."""
    sums = np.add.reduceat(np.append(values, 0.0), borders[:-1])
    return np.where(borders[1:] > borders[:-1], sums, 0.0)
