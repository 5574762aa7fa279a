"""Measured differences between tracks and their decoded form in a format: by band, in level and at
onsets."""

from __future__ import annotations

import enum
import math
from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ...core.arrays import BoolArray, FloatArray, IntArray
from ...core.formats.tracks.fidelity import (
    LOST_LIMIT,
    SILENT,
    ListenerFidelity,
    Progress,
    by_listener,
    decibels,
    percent,
)
from ...core.formats.tracks.listener_tracks import PIECE, Tracks
from ...core.frozen import frozen
from .onsets import RATE, away_from, onsets

EDGES = (0.0, 5.0, 20.0, 40.0, 80.0, 160.0, 320.0, 640.0, 1000.0)
"""Edges of the bands (hertz); the last band reaches up to half the sample rate."""
WINDOW = 1.0
"""Length of the windows of the spectra (seconds)."""
FARTHEST_LAG = 50
"""Largest detectable shift of an onset (milliseconds)."""
MOST_ONSETS = 100
"""Onsets of a listener whose shift is measured."""
LONGEST_ENVELOPE = 1000
"""Length of the envelopes that are kept (seconds)."""

LOWEST_RATE = 2500
"""Least sample rate of the decoded signal (hertz)."""

STEADY = 1.5
"""Frequency (hertz) below which a signal is a steady push, which nobody feels and no actuator
plays: it counts in no level."""
MISSED = 0.25
"""An onset is missing if the rise of the envelope is less than this share of the original's (-12
dB)."""
MOST_NAMED, MOST_TIMES, MOST_LINES = 12, 4, 3
"""Listeners and onsets that a sentence names, and sentences about onsets."""

LEVEL_LIMIT = 3.0
"""Change of level [dB] above which replacing a file needs consent."""
ONSET_LIMIT = 20.0
"""Shift of onsets [ms] above which replacing a file needs consent."""

_BEFORE, _AFTER = 30, 120
_MOMENT = 6
"""Milliseconds of a quiet moment: no tone has one, but a train of 60 pulses a second does."""
_ALL = 2
"""The bin of the spectra, of a frequency that counts, that has all power where none is computed."""


class Kind(enum.Enum):
    """The aspect of a vibration that a format keeps, by which its files are compared."""

    WAVE = "wave"  # the samples themselves: their difference is an error
    SPECTRUM = "spectrum"  # amplitude and frequency, but no phase: power by band is compared
    LEVEL = "level"  # amplitude alone


@frozen
class Measures:
    """How files of a format are compared with the tracks: by what aspect of the vibration, and from
    ``low`` to ``high`` hertz."""

    kind: Kind
    low: float = 0.0
    high: float = math.inf


@frozen
class Fidelity:
    """The measured losses of a format over all listeners, and of each listener.

    low, high: the frequencies (hertz) that it addresses. beyond: share of the power outside of
    them. lost: share of all power that is not reproduced, None unless waves are kept;
    ``lost_within``: of the power between ``low`` and ``high``. band_levels: (low, high, change of
    level in dB) of the bands between ``low`` and ``high`` with at least 1 % of the power. level:
    change of the level (dB), between ``low`` and ``high`` if waves are kept. onset: 95th percentile
    of the shifts of onsets (milliseconds), None without onsets. listeners: the losses of each,
    those who lose most first.
    """

    kind: Kind
    low: float
    high: float
    beyond: float
    lost: float | None
    lost_within: float | None
    band_levels: tuple[tuple[float, float, float], ...]
    level: float
    onset: float | None
    listeners: tuple[ListenerFidelity, ...]

    @property
    def is_poor(self) -> bool:
        """Whether the losses are so large, in all or at one listener, that overwriting a file needs
        consent."""
        lost = self.beyond if self.lost is None else self.lost
        levels = (self.level, *(listener.level for listener in self.listeners))
        return (
            lost > LOST_LIMIT
            or max(map(abs, levels)) > LEVEL_LIMIT
            or (self.onset or 0.0) > ONSET_LIMIT
        )

    def sentences(self) -> Iterator[str]:
        """The measurements as sentences."""
        span = f"{self.low:g} to {self.high:g} Hz"
        if self.beyond >= 0.0005:
            yield f"{percent(self.beyond)} of the power, which lies outside of {span}"
        if self.lost_within is not None:
            yield f"{percent(self.lost_within)} of the power from {span}"
        changes = [change for _, _, change in self.band_levels]
        by_band = f", by band {min(changes):+z.1f} to {max(changes):+z.1f} dB" if changes else ""
        yield f"levels change by {self.level:+z.1f} dB{by_band}"
        if self.onset is not None:
            yield f"onsets shift by up to {self.onset:g} ms"
        if len(self.listeners) > 1:
            yield f"by listener, most lost first: {_first(map(_of_listener, self.listeners))}"
        for word in ("missing", "invented"):
            sharing: dict[tuple[float, ...], list[str]] = {}
            for listener in self.listeners:
                sharing.setdefault(getattr(listener, word), []).append(listener.name)
            sharing.pop((), None)
            for times, names in list(sharing.items())[:MOST_LINES]:
                first = _first((f"{time:.3f} s" for time in times), MOST_TIMES)
                yield f"onsets {word} at {_first(names)}: {first}"
            others = list(sharing.items())[MOST_LINES:]
            if others:
                listeners = sum(len(names) for _, names in others)
                count = sum(len(names) * len(times) for times, names in others)
                yield f"onsets {word} at {listeners} other listeners: {count}"


def _of_listener(listener: ListenerFidelity) -> str:
    lost = "" if listener.lost is None else f"{percent(listener.lost)} of the power, "
    return f"{listener.name} {lost}{listener.level:+z.1f} dB"


def _first(items: Iterable[str], most: int = MOST_NAMED) -> str:
    """The first items, and the number of the others."""
    every = list(items)
    return ", ".join(every[:most]) + (f" and {len(every) - most} more" if every[most:] else "")


class Comparison:
    """Collects the measures while a format of ``tracks`` is written.

    ``add`` is called for each listener with consecutive pieces of the decoded signal: samples, or
    amplitudes for `Kind.LEVEL`. ``thinning``: decimation factor of the decoded signal, because only
    formats that keep samples have frequencies above 1000 Hz. ``progress``: called after each piece
    with the share that is written; its exceptions end the writing.
    """

    def __init__(self, tracks: Tracks, measures: Measures, progress: Progress = None) -> None:
        self.tracks = tracks
        self.kind, self.low, self.high = measures.kind, measures.low, measures.high
        self._progress = progress
        self._rate = tracks.sample_rate
        self.thinning = max(self._rate // LOWEST_RATE, 1)
        self._listeners = [
            _Listener(tracks, number, self.thinning, self.kind)
            for number in range(len(tracks.listeners))
        ]

    def add(self, listener: int, decoded: FloatArray) -> None:
        """Add the decoded signal of the next n samples of a listener, shape (ceil(n /
        thinning),)."""
        self._listeners[listener].add(decoded)
        if self._progress is not None:
            self._progress(
                sum(part.done for part in self._listeners) / max(self.tracks.samples.size, 1)
            )

    def result(self) -> Fidelity | None:
        """The measures of all added samples; None for silence."""
        parts = np.array([part.finished() for part in self._listeners])
        parts[:, :, [0, -1]] /= 2  # these bins have no counterpart at negative frequencies
        hertz = np.arange(self._bins) / (2 * (self._bins - 1)) * self._rate
        parts[:, :, hertz < STEADY] = 0.0
        original, decoded, error = parts.sum(axis=0)
        within = (hertz >= self.low) & (hertz <= self.high)
        total = float(original.sum())
        if total <= SILENT:
            return None
        is_wave = self.kind is Kind.WAVE
        compared = within if is_wave else np.ones(self._bins, dtype=np.bool_)
        lags = [lag for part in self._listeners for lag in part.lags()]
        powers = parts[:, :, compared].sum(axis=2)
        return Fidelity(
            kind=self.kind,
            low=self.low,
            high=min(self.high, self._rate / 2),
            beyond=float(original[~within].sum()) / total,
            lost=float(error.sum()) / total if is_wave else None,
            lost_within=float(error[within].sum()) / max(float(original[within].sum()), SILENT)
            if is_wave
            else None,
            band_levels=()
            if self.kind is Kind.LEVEL
            else tuple(_band_levels(hertz, original, decoded, within)),
            level=decibels(float(decoded[compared].sum()), float(original[compared].sum())),
            onset=float(np.percentile(np.abs(lags), 95)) if lags else None,
            listeners=by_listener(
                [part.name for part in self._listeners],
                powers,
                [part.changed_onsets() for part in self._listeners],
                has_error=is_wave,
            ),
        )

    @property
    def _bins(self) -> int:
        return _size(self._rate, self.thinning) // 2 + 1


def _size(rate: int, thinning: int) -> int:
    """Samples of a window: a multiple of 4 and of the thinning."""
    return 4 * thinning * max(round(WINDOW * rate / (4 * thinning)), 1)


def _band_levels(
    hertz: FloatArray, original: FloatArray, decoded: FloatArray, within: BoolArray
) -> Iterator[tuple[float, float, float]]:
    edges = [*EDGES, math.inf]
    for low, high in pairwise(edges):
        band = (hertz >= low) & (hertz < high) & within
        power = float(original[band].sum())
        if power >= 0.01 * float(original.sum()):
            yield low, min(high, float(hertz[-1])), decibels(float(decoded[band].sum()), power)


class _Listener:
    """The measures of one listener; ``done``: of how many samples."""

    def __init__(self, tracks: Tracks, number: int, thinning: int, kind: Kind) -> None:
        track, rate = tracks.listeners[number], tracks.sample_rate
        self.name, self._impacts = track.name, track.impacts[:, 0]
        self._row = tracks.row(number)
        self._thinning, self._kind = thinning, kind
        self.done = 0
        size = _size(rate, thinning)
        # Sine windows with half an overlap: their squares add up to 1, so that powers add up to the
        # signal's.
        self._shape = np.sin(math.pi * (np.arange(size) + 0.5) / size)
        self._pending = [np.zeros(size // 2), np.zeros(size // 2 // thinning)]
        self._sums = np.zeros((3, size // 2 + 1))
        self._envelopes = _Envelope(rate), _Envelope(rate / thinning)

    def add(self, decoded: FloatArray) -> None:
        step = PIECE // self._thinning
        for k in range(0, len(decoded), step):
            played = decoded[k : k + step]
            end = min(self.done + len(played) * self._thinning, self._row.count)
            pieces = self._row.read(self.done, end), played
            self.done = end
            for envelope, samples in zip(self._envelopes, pieces, strict=True):
                envelope.add(samples)
            self._pending = [
                np.concatenate(pair) for pair in zip(self._pending, pieces, strict=True)
            ]
            self._transform()

    def finished(self) -> FloatArray:
        """Power of the original, of the decoded signal, and of the error, by frequency, shape (3,
        bins)."""
        size = len(self._shape)
        self._pending = [
            np.pad(part, (0, size // step))
            for part, step in zip(self._pending, (1, self._thinning), strict=True)
        ]
        self._transform()
        return self._sums

    def _transform(self) -> None:
        size = len(self._shape)
        step = self._thinning
        hop = size // 2
        count = min(len(self._pending[0]) // hop, len(self._pending[1]) // (hop // step)) - 1
        if count < 1:
            return
        wholes, thins = (
            sliding_window_view(part, size // every)[:: hop // every][:count] * self._shape[::every]
            for part, every in zip(self._pending, (1, step), strict=True)
        )
        self._pending = [self._pending[0][count * hop :], self._pending[1][count * hop // step :]]
        if self._kind is Kind.LEVEL:
            played = [
                np.pad([step * math.sqrt(float(np.dot(thin, thin)) * size / (4 * step))], (_ALL, 0))
                for thin in thins
            ]
        else:
            # The spectrum of the decimated signal equals that of the full one up to half of its
            # rate.
            played = list(step * np.fft.rfft(thins)[:, :-1])
        # The windows are transformed at once, because each call computes the factors of the
        # transform anew.
        for original, decoded in zip(np.fft.rfft(wholes), played, strict=True):
            carried = len(decoded)  # the decoded signal has no power in the bins above
            power = original.real**2 + original.imag**2
            error = original[:carried] - decoded
            self._sums[0] += power
            self._sums[1, :carried] += decoded.real**2 + decoded.imag**2
            power[:carried] = error.real**2 + error.imag**2
            self._sums[2] += power

    def _events(self, original: FloatArray) -> IntArray:
        """Milliseconds of the original's onsets: of its impacts, and of other sudden rises."""
        others = away_from(onsets(original**2), self._impacts)
        return np.union1d(np.rint(self._impacts * RATE).astype(np.int64), others)

    def changed_onsets(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Times (seconds) of the onsets that the decoded signal lacks, and of those that only it
        has."""
        original, decoded = (envelope.values() for envelope in self._envelopes)

        def only(events: IntArray, here: FloatArray, there: FloatArray) -> tuple[float, ...]:
            events = events[events < min(len(here), len(there))]
            rises, stand_out = _rises(here, events)
            lost = stand_out & (_rises(there, events)[0] < MISSED * rises)
            return tuple((events[lost] / RATE).tolist())

        return only(self._events(original), original, decoded), only(
            onsets(decoded**2), decoded, original
        )

    def lags(self) -> list[float]:
        """Shifts of onsets (milliseconds), positive for late ones."""
        original, decoded = (envelope.values() for envelope in self._envelopes)
        events = self._events(original)
        lags = []
        for onset in events[:: len(events) // MOST_ONSETS + 1].tolist():
            window = original[max(onset - _BEFORE, 0) : onset + _AFTER]
            around = decoded[max(onset - _BEFORE, 0) : onset + _AFTER]
            if len(window) == _BEFORE + _AFTER and window.any() and around.any():
                lags.append(_lag(window - window.mean(), around - around.mean()))
        return lags


class _Envelope:
    """Root mean squares of every millisecond; none below ``RATE`` samples a second."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._count = 0
        self._leftover = np.zeros(0)
        self._pieces: list[NDArray[np.float32]] = []

    def add(self, samples: FloatArray) -> None:
        # The millisecond that the leftover begins.
        first = math.floor(self._count / self._rate * RATE + 1e-9)
        if self._rate < RATE or first > LONGEST_ENVELOPE * RATE:
            return
        both = np.concatenate([self._leftover, samples])
        last = math.floor((self._count + len(both)) / self._rate * RATE + 1e-9)
        borders = (
            np.ceil(np.arange(first, last + 1) * (self._rate / RATE) - 1e-9).astype(np.int64)
            - self._count
        )
        if last <= first:
            self._leftover = both
            return
        sums = np.add.reduceat(both[: borders[-1]] ** 2, borders[:-1])
        self._pieces.append(np.sqrt(sums / np.diff(borders)).astype(np.float32))
        self._leftover = both[borders[-1] :]
        self._count += int(borders[-1])

    def values(self) -> FloatArray:
        return np.concatenate(self._pieces).astype(np.float64) if self._pieces else np.zeros(0)


def _lag(window: FloatArray, around: FloatArray) -> float:
    """The shift with the highest correlation, 0 if there is none."""
    shifts = np.arange(-FARTHEST_LAG, FARTHEST_LAG + 1)
    padded = np.pad(around, FARTHEST_LAG)
    views = sliding_window_view(padded, len(window))
    products = views @ window
    best = float(products.max())
    near = shifts[products >= best - 1e-6 * abs(best)]
    return float(near[np.argmin(np.abs(near))])


def _rises(envelope: FloatArray, onsets: IntArray) -> tuple[FloatArray, BoolArray]:
    """By how much an envelope exceeds, from shortly before each of the onsets (milliseconds) on,
    its quietest moment before that, and whether it is twice its mean before."""
    early = _BEFORE + FARTHEST_LAG // 2
    padded = np.pad(envelope, (early, FARTHEST_LAG))
    around = sliding_window_view(padded, early + FARTHEST_LAG)[onsets]
    before = around[:, :_BEFORE]
    largest = around[:, _BEFORE:].max(axis=1)
    quietest = sliding_window_view(before, _MOMENT, axis=1).mean(axis=2).min(axis=1)
    return largest - quietest, largest > 2 * before.mean(axis=1)
