"""Paths of voices to listeners in one frame: direct, delayed, and those of steady tones."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..signals.interpolation import ZERO_CROSSINGS, local_polynomials
from .filter_bank import bank_response
from .gains import FrameSamples
from .groups import Group
from .tone_paths import TonePaths
from .voices import Stream, sample_brief


def paths_of(frame: FrameSamples, group: Group) -> list[DirectPaths | DelayedPaths | SteadyPaths]:
    """Return the paths of a group: those of steady tones separately if bands or delays make samples
    costly."""
    if group.delays is None and group.streams[0].row_count == 1:
        return [DirectPaths(frame, group)]
    longest = group.longest_delays().tolist()
    steady = [
        frame.count > 0 and stream.is_steady(frame.start - delay)
        for stream, delay in zip(group.streams, longest, strict=True)
    ]
    paths: list[DirectPaths | DelayedPaths | SteadyPaths] = []
    if any(steady):
        paths.append(
            SteadyPaths(
                frame, group.chosen([index for index, is_steady in enumerate(steady) if is_steady])
            )
        )
    if not all(steady):
        rest = group.chosen([index for index, is_steady in enumerate(steady) if not is_steady])
        paths.append(
            DirectPaths(frame, rest) if group.delays is None else DelayedPaths(frame, rest)
        )
    return paths


class DirectPaths:
    """Paths without delay: all listeners get the same samples times their gains, so a sum over
    voices is a matrix product."""

    def __init__(self, frame: FrameSamples, group: Group) -> None:
        self.group = group = _sounding(frame, group)
        self._factors, self._curves = group.gains.terms(frame)
        sample_brief(group.streams)
        rows = [stream.rows(frame.first, frame.last) for stream in group.streams]
        shape = len(group.streams), self._factors.shape[3], frame.count
        self._rows = np.concatenate(rows).reshape(shape) if rows else np.empty(shape)

    def summed(self) -> FloatArray:
        """Return the sum over voices, shape (n_listeners, n)."""
        terms, voices, listeners, bands = self._factors.shape
        count = self._rows.shape[2]
        factors = self._factors.transpose(0, 2, 1, 3).reshape(terms, listeners, voices * bands)
        rows = self._rows.reshape(voices * bands, count)
        # Terms for all samples are summed in one product. (`einsum` computes on this thread; BLAS
        # would start others, which stay busy.)
        whole = sum(len(curve) == count for curve in self._curves)
        sums = np.einsum(
            "lv,vn->ln", factors[:whole].reshape(whole * listeners, voices * bands), rows
        ).reshape(whole, listeners, count)
        total: FloatArray = sums[0]
        for term, curve in zip(sums[1:], self._curves[1:], strict=False):
            total += term * curve
        for factor, curve in zip(factors[whole:], self._curves[whole:], strict=True):
            total[:, : len(curve)] += np.einsum("lv,vn->ln", factor, rows[:, : len(curve)]) * curve
        return total

    def at_listeners(self, listeners: list[int]) -> FloatArray:
        """Return the voices as they reach some listeners, shape (n_voices, n_chosen, n)."""
        terms, voices, _, bands = self._factors.shape
        count = self._rows.shape[2]
        factors = (
            self._factors[:, :, listeners]
            .transpose(1, 2, 0, 3)
            .reshape(voices, len(listeners), terms * bands)
        )
        rows = np.empty((voices, terms, bands, count))
        rows[:, 0] = self._rows
        for term, curve in enumerate(self._curves[1:], 1):
            np.multiply(self._rows[:, :, : len(curve)], curve, out=rows[:, term, :, : len(curve)])
            rows[:, term, :, len(curve) :] = 0.0
        return np.einsum(
            "vlt,vtn->vln",
            factors,
            rows.reshape(voices, terms * bands, count),
            out=_scratch(voices, len(listeners), count),
        )


class DelayedPaths:
    """Paths with a delay each: the signal at an earlier time, which moves as the delay changes."""

    def __init__(self, frame: FrameSamples, group: Group) -> None:
        self.group = group = _sounding(frame, group)
        assert group.delays_before is not None and group.delays is not None
        factors, curves = group.gains.terms(frame)
        self._voices = np.zeros((len(group.streams), group.audible.shape[1], frame.count))
        for number, voice in enumerate(self._voices):
            heard_by = group.audible[number]
            paths: slice | BoolArray = slice(None) if heard_by.all() else heard_by
            before = group.delays_before[number, paths, None]
            after = group.delays[number, paths, None]
            stream = group.streams[number]
            travel = (
                _travelled_between_samples
                if stream.row_count > 1 or stream.is_recorded
                else _travelled
            )
            delays = (after - before) * frame.ramp
            delays += before
            voice[paths] = travel(stream, frame.times - delays, factors[:, number, paths], curves)

    def summed(self) -> FloatArray:
        """Return the sum over voices, shape (n_listeners, n)."""
        return np.asarray(self._voices.sum(axis=0))

    def at_listeners(self, listeners: list[int]) -> FloatArray:
        """Return the voices as they reach some listeners, shape (n_voices, n_chosen, n)."""
        return self._voices[:, listeners]


class SteadyPaths(TonePaths):
    """Paths of steady tones with bands or delays: the filter of a band is a gain, and a delay a
    turn of phase."""

    def __init__(self, frame: FrameSamples, group: Group) -> None:
        self.group = group
        rate = group.streams[0].sample_rate
        count = frame.count
        tones = np.array([_tone_values(stream) for stream in group.streams])
        frequency, amplitude, phase, onset = tones.T[:, :, None]
        factors, curves = group.gains.terms(frame)
        if factors.shape[3] > 1:
            factors = (
                factors
                @ np.array([bank_response(hertz, rate) for hertz in frequency[:, 0].tolist()])[
                    :, :, None
                ]
            )
        late = lag_step = np.zeros((len(group.streams), 1))
        if group.delays is not None and group.delays_before is not None:
            before = np.where(group.audible, group.delays_before, 0.0)
            drift = np.where(group.audible, group.delays, 0.0) - before
            late = before + drift * frame.ramp[0]
            lag_step = drift * ((frame.ramp[-1] - frame.ramp[0]) / max(count - 1, 1))
        start = frequency * (frame.times[0] - onset - late) + phase
        step = frequency * (1.0 / rate - lag_step)
        super().__init__(
            start.T, step.T, (factors[..., 0] * amplitude).transpose(0, 2, 1), curves, count
        )


def _sounding(frame: FrameSamples, group: Group) -> Group:
    """Return the streams that are heard in a frame with samples."""
    heard = np.asarray(group.audible.any(axis=1)).tolist()
    longest = group.longest_delays().tolist()
    late = zip(group.streams, longest, strict=True)
    sounds = [
        frame.count > 0 and stream.sounds(frame.start - delay, frame.end) for stream, delay in late
    ]
    return group.chosen(
        [index for index, is_heard in enumerate(heard) if is_heard and sounds[index]]
    )


def _travelled(
    stream: Stream, times: FloatArray, factors: FloatArray, curves: Sequence[FloatArray]
) -> FloatArray:
    """Return a signal at `times`, shape (n_paths, n), times the gains of its paths, which are given
    as by `Gains.terms`; factors: shape (n_terms, n_paths, 1)."""
    gains = _gains_over_time(factors, curves)
    gains *= stream.signal.at(times.ravel() - stream.onset, 1.0 / stream.sample_rate).reshape(
        times.shape
    )
    return gains


def _travelled_between_samples(
    stream: Stream, times: FloatArray, factors: FloatArray, curves: Sequence[FloatArray]
) -> FloatArray:
    """Return what `_travelled` does, interpolated between samples of the signal, or of its bands
    where gains are by band; factors: shape (n_terms, n_paths, 1 or 6)."""
    positions = times * stream.sample_rate
    first = math.floor(np.min(positions)) - ZERO_CROSSINGS
    rows = stream.rows(first, math.ceil(np.max(positions)) + ZERO_CROSSINGS + 1)
    polynomials = local_polynomials(rows)
    whole = np.floor(positions)
    place = whole.astype(np.intp) - (first + ZERO_CROSSINGS - 1)
    powers = _powers(2.0 * (positions - whole) - 1.0, polynomials.shape[2])
    # With a constant delay samples are consecutive, and a slice is faster than an index.
    places: list[slice | IntArray] = [
        slice(path[0], path[0] + len(path)) if follows else path
        for path, follows in zip(place, (np.diff(place) == 1).all(axis=1).tolist(), strict=True)
    ]
    sounding = (times >= stream.onset) & (times < stream.end)
    if len(rows) == 1:
        values = np.array(
            [
                np.einsum("nd,nd->n", polynomials[0, at], power)
                for at, power in zip(places, powers, strict=True)
            ]
        )
        return values * _gains_over_time(factors, curves) * sounding
    # The bands are weighed and added before they are interpolated.
    result = np.zeros(times.shape)
    for factor, curve in zip(factors, curves, strict=True):
        count = len(curve)
        weighed = np.einsum("pb,bnd->pnd", factor, polynomials)
        for path, polynomial, at, power in zip(result, weighed, places, powers, strict=True):
            near = polynomial[at][:count] if isinstance(at, slice) else polynomial[at[:count]]
            path[:count] += np.einsum("nd,nd->n", near, power[:count]) * curve
    if stream.tone is not None:
        # As soon as a tone is steady, its bands are known exactly, however frames are cut.
        response = bank_response(float(stream.tone.frequency), stream.sample_rate)  # type: ignore[arg-type]
        known = stream.tone.at(times.ravel() - stream.onset, 1.0 / stream.sample_rate).reshape(
            times.shape
        )
        known *= _gains_over_time(factors @ response[:, None], curves)
        result = np.where(times >= stream.settled, known, result)
    return result * sounding


def _gains_over_time(factors: FloatArray, curves: Sequence[FloatArray]) -> FloatArray:
    """Return gains of some paths, shape (n_paths, n), from terms; factors: shape (n_terms, n_paths,
    1)."""
    gains = np.empty((factors.shape[1], len(curves[0])))
    gains[:] = factors[0]
    for factor, curve in zip(factors[1:], curves[1:], strict=True):
        gains[:, : len(curve)] += factor * curve
    return gains


class _Scratch(threading.local):
    """Reused memory for large arrays of a frame, whose allocation would cost more than the
    computation."""

    room = np.empty(0)


_scratches = _Scratch()


def _scratch(*shape: int) -> FloatArray:
    """Return an uninitialised array, which is valid until the next call in this thread."""
    size = math.prod(shape)
    if size > len(_scratches.room):
        _scratches.room = np.empty(size)
    return _scratches.room[:size].reshape(shape)


def _powers(base: FloatArray, count: int) -> FloatArray:
    """Return base^0 to base^(count - 1) in a new last axis."""
    powers = np.empty((*base.shape, count))
    powers[..., 0] = 1.0
    for degree in range(1, count):
        np.multiply(powers[..., degree - 1], base, out=powers[..., degree])
    return powers


def _tone_values(stream: Stream) -> tuple[float, float, float, float]:
    """Return frequency, amplitude, phase and onset of a stream that is a steady tone."""
    tone = stream.tone
    assert (
        tone is not None and isinstance(tone.frequency, float) and isinstance(tone.amplitude, float)
    )
    return tone.frequency, tone.amplitude, tone.phase, stream.onset
