"""Paths of voices to listeners in one frame: direct, delayed, and those of steady tones."""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..signals.interpolation import ZERO_CROSSINGS, local_polynomials
from .filter_bank import bank_response
from .tone_paths import TonePaths
from .voices import Stream, Voice


@dataclass(frozen=True, slots=True)
class Frame:
    """The samples `first` to `last - 1` at `times`, and how far (0 to 1) each is from the frame's start to its end."""

    start: float
    end: float
    first: int
    last: int
    times: FloatArray
    ramp: FloatArray

    @property
    def count(self) -> int:
        return self.last - self.first


class Part(NamedTuple):
    """A stream in one frame. Without a voice it fades out; one that begins has its full gain from its onset on."""

    stream: Stream
    voice: Voice | None
    begins: bool


@dataclass(frozen=True, slots=True)
class Group:
    """Parts of one kind and their gains at a frame's start and end, shape (n_parts, n_listeners) or (n_parts, n_listeners, 6)."""

    parts: list[Part]
    before: FloatArray
    gains: FloatArray
    delays_before: FloatArray | None
    delays: FloatArray | None

    def chosen(self, index: list[int]) -> Group:
        """Return some of the parts."""
        if len(index) == len(self.parts):
            return self
        delays_before = None if self.delays_before is None else self.delays_before[index]
        delays = None if self.delays is None else self.delays[index]
        return Group([self.parts[number] for number in index], self.before[index], self.gains[index], delays_before, delays)


def paths_of(frame: Frame, group: Group) -> list[DirectPaths | DelayedPaths | SteadyPaths]:
    """Return the paths of a group: those of steady tones by themselves where bands or delays make samples costly."""
    if group.delays is None and group.parts[0].stream.row_count == 1:
        return [DirectPaths(frame, group)]
    longest = _longest_delays(group).tolist()
    steady = [frame.count > 0 and part.stream.is_steady(frame.start - delay) for part, delay in zip(group.parts, longest, strict=True)]
    paths: list[DirectPaths | DelayedPaths | SteadyPaths] = []
    if any(steady):
        paths.append(SteadyPaths(frame, group.chosen([index for index, is_steady in enumerate(steady) if is_steady])))
    if not all(steady):
        rest = group.chosen([index for index, is_steady in enumerate(steady) if not is_steady])
        paths.append(DirectPaths(frame, rest) if group.delays is None else DelayedPaths(frame, rest))
    return paths


class DirectPaths:
    """What listeners get without delay: the same samples for all, times gains on a ramp, so a sum over voices is a matrix product."""

    def __init__(self, frame: Frame, group: Group) -> None:
        heard = np.any(audible(group.before) | audible(group.gains), axis=1).tolist()
        chosen = [index for index, part in enumerate(group.parts) if heard[index] and part.stream.sounds(frame.start, frame.end)]
        self.parts = [group.parts[index] for index in chosen]
        self._ramp = frame.ramp
        row_count, count = group.parts[0].stream.row_count, len(chosen)
        rows = [part.stream.rows(frame.first, frame.last) for part in self.parts]
        self._rows = np.concatenate(rows or [np.empty((0, frame.count))]).reshape(count, row_count, frame.count)
        # (parts, 2, listeners, rows): gains at the frame's start, and their change.
        before, after = (group.before, group.gains) if count == len(heard) else (group.before[chosen], group.gains[chosen])
        self._gains = np.empty((count, 2, before.shape[1], row_count))
        self._gains[:, 0] = before.reshape(count, before.shape[1], row_count)
        np.subtract(after.reshape(self._gains[:, 0].shape), self._gains[:, 0], out=self._gains[:, 1])

    def summed(self) -> FloatArray:
        """Return the sum over voices, shape (n_listeners, n)."""
        parts, _, listeners, row_count = self._gains.shape
        gains = self._gains.transpose(1, 2, 0, 3).reshape(2 * listeners, parts * row_count)
        both = gains @ self._rows.reshape(parts * row_count, self._rows.shape[2])
        return np.asarray(both[:listeners] + both[listeners:] * self._ramp)

    def at_listeners(self, listeners: list[int]) -> FloatArray:
        """Return the voices as they reach some listeners, shape (n_voices, n_chosen, n)."""
        gains = np.concatenate((self._gains[:, 0, listeners], self._gains[:, 1, listeners]), axis=2)
        voices = _scratch(len(self.parts), len(listeners), len(self._ramp))
        return np.matmul(gains, np.concatenate((self._rows, self._rows * self._ramp), axis=1), out=voices)


class DelayedPaths:
    """What listeners get along paths with a delay each: the signal at an earlier time, which moves as the delay changes."""

    def __init__(self, frame: Frame, group: Group) -> None:
        assert group.delays_before is not None and group.delays is not None
        heard = audible(group.before) | audible(group.gains)
        longest = _longest_delays(group).tolist()
        chosen = [
            index
            for index, part in enumerate(group.parts)
            if heard[index].any() and frame.count and part.stream.sounds(frame.start - longest[index], frame.end)
        ]
        self.parts = [group.parts[index] for index in chosen]
        self._voices = np.zeros((len(chosen), heard.shape[1], frame.count))
        for voice, index in zip(self._voices, chosen, strict=True):
            paths = heard[index]
            before, delays_before = group.before[index, paths], group.delays_before[index, paths, None]
            delays = delays_before + (group.delays[index, paths, None] - delays_before) * frame.ramp
            stream = group.parts[index].stream
            travel = _travelled_between_samples if stream.row_count > 1 or stream.is_recorded else _travelled
            voice[paths] = travel(stream, frame.times - delays, before, group.gains[index, paths] - before, frame.ramp)

    def summed(self) -> FloatArray:
        """Return the sum over voices, shape (n_listeners, n)."""
        total: FloatArray = self._voices.sum(axis=0)
        return total

    def at_listeners(self, listeners: list[int]) -> FloatArray:
        """Return the voices as they reach some listeners, shape (n_voices, n_chosen, n)."""
        return self._voices[:, listeners]


class SteadyPaths:
    """What listeners get of steady tones, along paths with bands or delays: a band's filter is a gain, and a delay a turn of phase."""

    def __init__(self, frame: Frame, group: Group) -> None:
        self.parts = group.parts
        rate, count = group.parts[0].stream.sample_rate, frame.count
        tones = np.array([_tone_values(part.stream) for part in group.parts])
        frequency, amplitude, phase, onset = np.hsplit(tones, 4)
        before, after = group.before, group.gains
        if before.ndim == 3:
            response = np.array([bank_response(hertz, rate) for hertz in frequency[:, 0].tolist()])[:, :, None]
            before, after = (before @ response)[:, :, 0], (after @ response)[:, :, 0]
        before, change = before * amplitude, (after - before) * amplitude
        ramp = float(frame.ramp[0])
        ramp_step = float(frame.ramp[-1] - frame.ramp[0]) / max(count - 1, 1)
        late = lag_step = np.zeros((len(tones), 1))
        if group.delays is not None and group.delays_before is not None:
            heard = audible(group.before) | audible(group.gains)
            delays_before = np.where(heard, group.delays_before, 0.0)
            drift = np.where(heard, group.delays, 0.0) - delays_before
            late, lag_step = delays_before + drift * ramp, drift * ramp_step
        start = frequency * (frame.times[0] - onset - late) + phase
        step = frequency * (1.0 / rate - lag_step)
        self._paths = TonePaths(start.T, step.T, (before + change * ramp).T, change.T * ramp_step, count)

    def summed(self) -> FloatArray:
        """Return the sum over voices, shape (n_listeners, n)."""
        return self._paths.summed()

    def at_listeners(self, listeners: list[int]) -> FloatArray:
        """Return the voices as they reach some listeners, shape (n_voices, n_chosen, n)."""
        return self._paths.at_listeners(listeners)


def _travelled(stream: Stream, times: FloatArray, before: FloatArray, change: FloatArray, ramp: FloatArray) -> FloatArray:
    """Return a signal at `times`, shape (n_paths, n), times gains that go from `before`, shape (n_paths,), by `change` along the ramp."""
    values = stream.signal.at(times.ravel() - stream.onset, 1.0 / stream.sample_rate).reshape(times.shape)
    return (before[:, None] + change[:, None] * ramp) * values


def _travelled_between_samples(stream: Stream, times: FloatArray, before: FloatArray, change: FloatArray, ramp: FloatArray) -> FloatArray:
    """The same from samples, with one gain or with gains by band, shape (n_paths, 6): what samples weigh is added first."""
    positions = times * stream.sample_rate
    first = math.floor(np.min(positions)) - ZERO_CROSSINGS
    rows = stream.rows(first, math.ceil(np.max(positions)) + ZERO_CROSSINGS + 1)
    polynomials = local_polynomials(rows)
    whole = np.floor(positions)
    place = whole.astype(np.intp) - (first + ZERO_CROSSINGS - 1)
    powers = _powers(2.0 * (positions - whole) - 1.0, polynomials.shape[2])
    result = np.empty(times.shape)
    if len(rows) == 1:
        for path, index, power in zip(result, place, powers, strict=True):
            np.einsum("nd,nd->n", polynomials[0, index], power, out=path)
        result *= before.reshape(-1, 1) + change.reshape(-1, 1) * ramp
        return result * ((times >= stream.onset) & (times < stream.end))
    gains = np.stack((before, change), axis=1).reshape(2 * len(before), len(rows))
    weighed = (gains @ polynomials.reshape(len(rows), -1)).reshape(len(before), 2, *polynomials.shape[1:])
    for path, (constant, rising), index, power in zip(result, weighed, place, powers, strict=True):
        np.einsum("nd,nd->n", constant[index], power, out=path)
        path += np.einsum("nd,nd->n", rising[index], power) * ramp
    if stream.tone is not None:
        # As soon as a tone is steady, what it is in the bands is known, however frames are cut.
        response = bank_response(float(stream.tone.frequency), stream.sample_rate)  # type: ignore[arg-type]
        known = (before @ response)[:, None] + (change @ response)[:, None] * ramp
        known *= stream.tone.at(times.ravel() - stream.onset, 1.0 / stream.sample_rate).reshape(times.shape)
        result = np.where(times >= stream.settled, known, result)
    return result * ((times >= stream.onset) & (times < stream.end))


class _Scratch(threading.local):
    """Room for large arrays that last for a frame: to get it from the system anew costs more than what is computed in it."""

    room = np.empty(0)


_scratches = _Scratch()


def _scratch(*shape: int) -> FloatArray:
    """Return an array with anything in it, which is good until the next call in this thread."""
    size = math.prod(shape)
    if size > len(_scratches.room):
        _scratches.room = np.empty(size)
    return _scratches.room[:size].reshape(shape)


def _longest_delays(group: Group) -> FloatArray:
    """Return the longest delay of each part in the frame, of what is heard, shape (n_parts,)."""
    if group.delays is None or group.delays_before is None:
        return np.zeros(len(group.parts))
    heard = audible(group.before) | audible(group.gains)
    return np.asarray(np.where(heard, np.maximum(group.delays_before, group.delays), 0.0).max(axis=1, initial=0.0))


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
    assert tone is not None and isinstance(tone.frequency, float) and isinstance(tone.amplitude, float)
    return tone.frequency, tone.amplitude, tone.phase, stream.onset


def audible(gains: FloatArray) -> BoolArray:
    """Return where a voice reaches a listener, shape (n_parts, n_listeners)."""
    return np.asarray(gains != 0.0 if gains.ndim == 2 else (gains != 0.0).any(axis=2))
