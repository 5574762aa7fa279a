"""Fitting keyframed oscillations to samples with a bounded error.

The spectrum is divided into overlapping bands whose weights add up to 1. The analytic signal of a
band has one amplitude and one phase. A segment of it is replaced by a linear amplitude and a
frequency of two linear pieces, such that the phase is right at both ends. Segments are halved until
the power of the error in each is within its share of the signal's power there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from ...core.arrays import BoolArray, FloatArray, IntArray
from ...core.formats.tracks.listener_tracks import Row
from ...core.frozen import frozen
from ...core.signals.keys import needed_keys
from .analytic import CONTEXT, Band, ComplexArray, Window, analytic_windows
from .carrier import Carrier

POWER_RATE = 125
"""Rate (hertz) at which the signal's power is evaluated."""
POWER_WINDOW = 0.064
"""Length of the window that averages the power (seconds)."""
LONGEST_SEGMENT = 0.5
"""Maximum time between keys (seconds) before redundant ones are removed."""
LONGEST_STEPS = 256
"""Maximum number of grid points between keys."""
EVEN = 0.002
"""Distance (hertz) from the line between its neighbours within which a frequency key is
redundant."""
ROUNDING = 0.1
"""Maximum phase error (cycles) within a segment due to rounded frequencies."""
SAMPLED = 8
"""Points of a segment that are evaluated first."""
LONGEST_REST = 0.03
"""Maximum silence within a carrier (seconds)."""
SEAM = 0.1
"""Time before the end of a window in which a carrier may be divided (seconds)."""


@frozen
class Fit:
    """Requirements of a fit.

    error: allowed power of the error relative to the signal's power at each time. floor: amplitude
    that counts as silence. lowest, highest: range of frequency keys (hertz). frequency_step
    (hertz), amplitude_step and time_step (seconds): keys are multiples of these; 0: any value.
    shortest: minimum time between keys (seconds), which takes precedence over ``error``. signed:
    allow negative amplitudes.
    """

    error: float = 0.03
    floor: float = 0.0005
    lowest: float = 1.0
    highest: float = 1000.0
    frequency_step: float = 0.0
    amplitude_step: float = 1e-5
    time_step: float = 0.0
    shortest: float = 0.0
    signed: bool = False


def fit_bands(
    row: Row, bands: Sequence[Band], fit: Fit
) -> Iterator[tuple[float, list[list[Carrier]]]]:
    """Fit the bands of a signal window by window.

    Yields, after each window, a time [s] up to which all carriers are known, and for each band the
    new carriers, sorted by time, the last of which may end a little later. A carrier longer than a
    window is divided at a zero crossing of its wave, where one player may follow another.
    """
    done = [0] * len(bands)
    for window in analytic_windows(row, bands):
        allowed = _allowed(row, window, bands, fit)
        fitted = []
        complete = math.inf
        for k, (band, z) in enumerate(zip(bands, window.parts, strict=True)):
            origin = round(window.origin * band.grid_rate)
            last = (
                len(z) - 1 if window.is_last else _quiet_point(z, band, window.origin, window.end)
            )
            fitted.append(
                _fit_band(
                    z,
                    band,
                    allowed[k],
                    window.origin,
                    (done[k] - origin, last),
                    row.count / row.sample_rate,
                    fit,
                )
            )
            done[k] = origin + last
            complete = min(complete, done[k] / band.grid_rate)
        yield (math.inf if window.is_last else complete), fitted


def _quiet_point(z: ComplexArray, band: Band, origin: int, end: int) -> int:
    """The point of the grid shortly before ``end`` (seconds) where the wave is nearest to zero."""
    last = round((end - origin) * band.grid_rate)
    points = np.arange(last - max(round(SEAM * band.grid_rate), 1), last + 1)
    wave = z[points] * np.exp(
        2j * math.pi * (band.centre * (points / band.grid_rate + origin) % 1.0)
    )
    return int(points[np.argmin(np.abs(wave.real))])


def _allowed(row: Row, window: Window, bands: Sequence[Band], fit: Fit) -> list[FloatArray]:
    """The error (squared magnitude) allowed to each band at each point of its grid.

    At each time up to half of the total is spent by leaving out the weakest bands; the others share
    the rest equally.
    """
    parts, rate = window.parts, row.sample_rate
    longest = max((len(z) - 1) / band.grid_rate for z, band in zip(parts, bands, strict=True))
    times = np.arange(math.ceil(longest * POWER_RATE) + 1) / POWER_RATE
    samples = row.read(window.origin * rate, min((window.end + CONTEXT) * rate, row.count))
    total = 2 * _moving_mean(samples**2, rate, times)
    budget = np.maximum(fit.error * total, fit.floor**2)
    powers = np.array(
        [
            _moving_mean(np.abs(z) ** 2, band.grid_rate, times)
            for z, band in zip(parts, bands, strict=True)
        ]
    )
    order = np.argsort(powers, axis=0, kind="stable")
    weakest = np.cumsum(np.take_along_axis(powers, order, axis=0), axis=0)
    left_out = weakest <= budget / 2
    number = np.count_nonzero(left_out, axis=0)
    spent = np.where(
        number > 0, np.take_along_axis(weakest, np.maximum(number - 1, 0)[None], axis=0)[0], 0.0
    )
    share = (budget - spent) / np.maximum(len(bands) - number, 1)
    allowed = np.empty_like(powers)
    np.put_along_axis(allowed, order, np.where(left_out, np.inf, share), axis=0)
    # A band that is left out may have any error; a finite limit can be interpolated.
    allowed = np.minimum(allowed, 4 * np.maximum(total, budget))
    return [
        np.interp(np.arange(len(z)) / band.grid_rate, times, row)
        for z, band, row in zip(parts, bands, allowed, strict=True)
    ]


def _moving_mean(values: FloatArray, rate: float, times: FloatArray) -> FloatArray:
    """Mean of ``values`` (at ``rate`` hertz) over the power window around each of ``times``."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    half = max(POWER_WINDOW / 2, 1 / rate)
    low = np.clip(np.floor((times - half) * rate).astype(np.int64), 0, len(values))
    high = np.clip(np.ceil((times + half) * rate).astype(np.int64) + 1, 0, len(values))
    return np.asarray(np.maximum(sums[high] - sums[low], 0.0) / np.maximum(high - low, 1))


def _runs(active: BoolArray, rest: int) -> Iterator[tuple[int, int]]:
    """First and last index of each run of True; runs at most ``rest`` apart are merged."""
    indices = np.flatnonzero(active)
    if not len(indices):
        return
    breaks = np.flatnonzero(np.diff(indices) > rest + 1)
    firsts = indices[np.concatenate([[0], breaks + 1])]
    lasts = indices[np.concatenate([breaks, [len(indices) - 1]])]
    yield from zip(firsts.tolist(), lasts.tolist(), strict=True)


def _fit_band(
    z: ComplexArray,
    band: Band,
    allowed: FloatArray,
    origin: int,
    span: tuple[int, int],
    duration: float,
    fit: Fit,
) -> list[Carrier]:
    """The carriers of one frequency band.

    Args:
        z: its analytic signal on the grid of the band (n,).
        band: the band.
        allowed: squared error allowed at each point of the grid (n,); what is weaker gets no
            carrier.
        origin: time at which ``z`` begins [s].
        span: first and last point of the grid that belong to this part.
        duration: of the track [s].
        fit: limits and steps of the format.
    """
    rate, centre = band.grid_rate, band.centre
    strength = _moving_mean(np.abs(z) ** 2, rate, np.arange(len(z)) / rate)
    # One more point on either side, so that the amplitude begins and ends near 0.
    runs = [
        (max(first - 1, span[0]), min(last + 1, span[1]))
        for first, last in _runs(strength > allowed, round(LONGEST_REST * rate))
    ]
    runs = [(first, last) for first, last in runs if first < last]
    if not runs:
        return []
    phase = np.unwrap(np.angle(z * z)) / 2 if fit.signed else np.unwrap(np.angle(z))
    amplitude = (z * np.exp(-1j * phase)).real
    offset = (
        _stepped(
            np.clip(_slope(z, rate, fit.signed) + centre, fit.lowest, fit.highest),
            fit.frequency_step,
        )
        - centre
    )
    grid = _Grid(rate, phase, amplitude, offset, allowed, fit, centre, origin)
    return grid.carriers(grid.keys(runs), duration)


def _slope(z: ComplexArray, rate: float, signed: bool) -> FloatArray:
    """Frequency (hertz) at each point from the phase differences to its neighbours, weighted by
    magnitude."""
    turns = z[1:] * z[:-1].conj()
    if signed:
        turns = turns * turns
    around = np.zeros(len(z), dtype=np.complex128)
    around[1:] += turns
    around[:-1] += turns
    return np.angle(around) * (rate / (2 * math.pi)) / (2 if signed else 1)


def _stepped(values: FloatArray, step: float) -> FloatArray:
    return np.asarray(np.rint(values / step) * step) if step else values


@frozen
class _Grid:
    """A frequency band on its grid.

    Attributes:
        rate: points of the grid per second.
        phase: relative to a tone at ``centre`` [rad].
        amplitude: at each point.
        offset: frequency at each point, relative to ``centre`` [Hz].
        allowed: squared error allowed at each point.
        fit: limits and steps of the format.
        centre: frequency of the band [Hz].
        origin: time at which the grid begins [s].
    """

    rate: float
    phase: FloatArray
    amplitude: FloatArray
    offset: FloatArray
    allowed: FloatArray
    fit: Fit
    centre: float
    origin: int

    def keys(self, runs: Sequence[tuple[int, int]]) -> list[IntArray]:
        """The grid points that become keys, for each run."""
        step = self.fit.frequency_step
        seconds = min(LONGEST_SEGMENT, ROUNDING / step) if step else LONGEST_SEGMENT
        longest = max(min(int(seconds * self.rate), LONGEST_STEPS), 1)
        borders = [np.append(np.arange(first, last, longest), last) for first, last in runs]
        start = np.concatenate([border[:-1] for border in borders]).astype(np.int64)
        end = np.concatenate([border[1:] for border in borders]).astype(np.int64)
        shortest = max(1, round(max(2 * self.fit.time_step, self.fit.shortest) * self.rate))
        accepted = [np.array([first for first, _ in runs], dtype=np.int64)]
        while len(start):
            good = end - start < 2 * shortest
            hopeful = ~good
            # Beyond half of the allowed error at a few points, a segment is divided without
            # evaluating all of them.
            allowance = SAMPLED * (self.allowed[start[hopeful]] + self.allowed[end[hopeful]]) / 2
            hopeful[hopeful] = self._error(start[hopeful], end[hopeful], SAMPLED) <= allowance
            good[hopeful] = self._error(start[hopeful], end[hopeful]) <= 0
            accepted.append(end[good])
            start = start[~good]
            end = end[~good]
            middle = (start + end) // 2
            start = np.concatenate([start, middle])
            end = np.concatenate([middle, end])
        points = np.unique(np.concatenate(accepted))
        lasts = np.searchsorted(points, [last for _, last in runs], side="right")
        firsts = np.searchsorted(points, [first for first, _ in runs])
        return [
            points[first:last] for first, last in zip(firsts.tolist(), lasts.tolist(), strict=True)
        ]

    def _error(self, start: IntArray, end: IntArray, most: int | None = None) -> FloatArray:
        """Excess of the error over the allowed one for each segment without a key inside.

        Squared magnitude, summed over all points, or over at most ``most``.
        """
        if not len(start):
            return np.zeros(0)
        length = end - start
        count = length if most is None else np.minimum(length, most)
        step = np.arange(count.sum()) - (np.cumsum(count) - count).repeat(count) + 1
        if most is not None:
            step = step * length.repeat(count) // count.repeat(count)
        point = start.repeat(count) + step
        before, middle = self._halves(length)
        slow = self._middle_offset(start, end, self.phase[start], before, middle)
        time = step / self.rate
        half = before.repeat(count)
        whole = (before + middle).repeat(count)
        first, centre, last = (
            values.repeat(count) for values in (self.offset[start], slow, self.offset[end])
        )
        late = np.maximum(time - half, 0.0)
        early = np.minimum(time, half)
        rise = np.divide(centre - first, half, out=np.zeros_like(half), where=half > 0)
        cycles = early * (first + rise * early / 2) + late * (
            centre + (last - centre) / (whole - half) * late / 2
        )
        off = self.phase[start].repeat(count) + 2 * math.pi * cycles - self.phase[point]
        share = step / length.repeat(count)
        level = (
            self.amplitude[start].repeat(count) * (1 - share)
            + self.amplitude[end].repeat(count) * share
        )
        actual = self.amplitude[point]
        error = (
            level * level + actual * actual - 2 * level * actual * np.cos(off) - self.allowed[point]
        )
        return np.add.reduceat(error, np.cumsum(count) - count)

    def _halves(self, length: IntArray) -> tuple[FloatArray, FloatArray]:
        """Time (seconds) before and after the frequency key in the middle of a segment of
        ``length`` grid steps."""
        whole = length / self.rate
        before = whole / 2
        if self.fit.time_step:
            before = np.floor(before / self.fit.time_step + 1e-9) * self.fit.time_step
        return before, whole - before

    def _middle_offset(
        self,
        start: IntArray,
        end: IntArray,
        phase: FloatArray,
        before: FloatArray,
        after: FloatArray,
    ) -> FloatArray:
        """Frequencies (m,) in the middle of segments, relative to the band's centre [Hz], with
        which the signal of each has the right phase at its end.

        Args:
            start: points of the grid at which the segments begin (m,).
            end: points at which they end (m,).
            phase: of the signal at their starts (m,) [rad].
            before: seconds from start to middle (m,).
            after: seconds from middle to end (m,).
        """
        cycles = (self.phase[end] - phase) / (2 * math.pi)
        middle = (2 * cycles - self.offset[start] * before - self.offset[end] * after) / (
            before + after
        )
        return (
            _stepped(
                np.clip(middle + self.centre, self.fit.lowest, self.fit.highest),
                self.fit.frequency_step,
            )
            - self.centre
        )

    def carriers(self, runs: Sequence[IntArray], duration: float) -> list[Carrier]:
        """The carriers with keys at the given grid points, without redundant keys, for all runs at
        once."""
        fit = self.fit
        lengths = np.array([len(keys) for keys in runs])
        keys = np.concatenate(runs)
        run = np.repeat(np.arange(len(runs)), lengths)
        first = np.cumsum(lengths) - lengths
        times = (keys - keys[first][run]) / self.rate
        key_run, key_times, frequencies = self._frequencies(keys, times, run)
        amplitudes = np.clip(
            _stepped(self.amplitude[keys], fit.amplitude_step), -1.0 if fit.signed else 0.0, 1.0
        )
        kept = needed_keys(times, amplitudes, 0.25 * np.sqrt(self.allowed[keys]), run)
        needed = needed_keys(
            key_times,
            frequencies,
            np.full(len(frequencies), 1e-9 if fit.frequency_step else EVEN),
            key_run,
        )
        start = keys[first] / self.rate + self.origin
        end = np.minimum(start + times[first + lengths - 1], duration)
        phase = (self.phase[keys[first]] + 2 * math.pi * self.centre * start + math.pi / 2) % (
            2 * math.pi
        )
        bounds = np.arange(len(runs) + 1)
        parts = np.searchsorted(run[kept], bounds).tolist()
        key_parts = np.searchsorted(key_run[needed], bounds).tolist()
        result = []
        for k in range(len(runs)):
            own = kept[parts[k] : parts[k + 1]]
            keyed = needed[key_parts[k] : key_parts[k + 1]]
            if end[k] > start[k] and amplitudes[own].any():
                ends = float(start[k]), float(end[k])
                result.append(
                    Carrier(
                        *ends,
                        float(phase[k]),
                        times[own],
                        amplitudes[own],
                        key_times[keyed],
                        frequencies[keyed],
                    )
                )
        return result

    def _frequencies(
        self, keys: IntArray, times: FloatArray, run: IntArray
    ) -> tuple[IntArray, FloatArray, FloatArray]:
        """Runs, times and values of the frequency keys, one in each segment, such that the phase is
        right at every border.

        Linear interpolation between keys gives a tridiagonal, strictly diagonally dominant system.
        """
        segment = np.flatnonzero(run[1:] == run[:-1])
        before, after = self._halves(keys[segment + 1] - keys[segment])
        key_run = run[segment]
        together = key_run[1:] == key_run[:-1]
        # Position of the border between two keys on the line between them.
        share = after[:-1] / (after[:-1] + before[1:])
        from_last = np.append(0.0, np.where(together, before[1:] * (1 - share) / 2, 0.0))
        from_next = np.append(np.where(together, after[:-1] * share / 2, 0.0), 0.0)
        own = before * (1 + np.append(1.0, np.where(together, share, 1.0))) / 2
        own += after * (1 + np.append(np.where(together, 1 - share, 1.0), 1.0)) / 2
        cycles = (self.phase[keys[segment + 1]] - self.phase[keys[segment]]) / (2 * math.pi)
        frequencies = _tridiagonal(from_last, own, from_next, cycles) + self.centre
        weights = own + np.append(from_last[1:], 0.0) + np.append(0.0, from_next[:-1])
        return key_run, times[segment] + before, self._rounded(frequencies, weights, key_run)

    def _rounded(self, frequencies: FloatArray, weights: FloatArray, run: IntArray) -> FloatArray:
        """The frequencies rounded and limited; the phase error of each is compensated by the
        following keys of its run."""
        fit = self.fit
        within = np.clip(frequencies, fit.lowest, fit.highest)
        if not fit.frequency_step and (within == frequencies).all():
            return within
        missing, last = 0.0, -1
        values = []
        for wanted, weight, number in zip(
            frequencies.tolist(), weights.tolist(), run.tolist(), strict=True
        ):
            if number != last:
                missing, last = 0.0, number
            value = min(max(wanted + missing / weight, fit.lowest), fit.highest)
            if fit.frequency_step:
                value = round(value / fit.frequency_step) * fit.frequency_step
            missing += (wanted - value) * weight
            missing -= round(missing)
            values.append(value)
        return np.array(values)


def _tridiagonal(
    lower: FloatArray, diagonal: FloatArray, upper: FloatArray, right: FloatArray
) -> FloatArray:
    """Solve ``lower[k] x[k-1] + diagonal[k] x[k] + upper[k] x[k+1] = right[k]``: each equation
    loses its unknown before, from the first to the last, then the one after, on the way back."""
    reduced: list[tuple[float, float]] = []
    after, known = 0.0, 0.0
    rows = zip(*(column.tolist() for column in (lower, diagonal, upper, right)), strict=True)
    for to_last, own, to_next, value in rows:
        pivot = own - to_last * after
        after, known = to_next / pivot, (value - to_last * known) / pivot
        reduced.append((after, known))
    solution = 0.0
    found = [solution := known - after * solution for after, known in reversed(reduced)]
    return np.array(found[::-1])
