"""Signals times gains: one block of samples per listener, frame after frame.

A signal is a function of time, so that nothing of it has to be kept from block to block: a voice is looked up where the frame needs it,
delayed paths at their own time, the bands' symmetric filters ahead of it. What is kept is where each gain and delay stood.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import repeat
from typing import NamedTuple

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..scene.bands import BAND_COUNT
from ..signals import Automation, Sampled, Signal, Sine
from ..signals.interpolation import ZERO_CROSSINGS, local_polynomials
from .filter_bank import bank_reach, bank_response, split_bands
from .mixing import Limiter, MixingMethod, mixed
from .tone_paths import TonePaths

SAMPLE_RATE = 8000.0
MAX_GAIN = 1e6
"""Largest magnitude of a gain and of an amplitude."""
MAX_DELAY = 60.0
"""Seconds."""
MAX_TIME = 1e6
"""Seconds before and after 0 within which frames lie."""
MAX_FRAME = 60.0
"""Seconds that a frame may last."""
_CHUNK = 4096
"""Samples of a signal are rendered in runs that begin at multiples of this: so they are the same to the last bit whatever the frames."""
_SNAP = 1e-6


@dataclass(frozen=True, slots=True)
class ListenerMix:
    """How a listener mixes what reaches it.

    s_max: the largest magnitude of a sample, > 0. gain: from 0 to 1e6, applied to the mix before the limit.
    priorities: weights by source key, for `weighted` and custom methods; a source not in it has its voice's priority.
    limiter: turn down smoothly (Limiter) instead of cutting at s_max.
    """

    name: str
    method: MixingMethod = "cumulative"
    s_max: float = 1.0
    gain: float = 1.0
    priorities: Mapping[Hashable, float] = field(default_factory=dict)
    limiter: bool = False

    def __post_init__(self) -> None:
        if not 0.0 < self.s_max <= MAX_GAIN:
            raise ValueError(f"s_max: must be above 0 and at most {MAX_GAIN:g}, not {self.s_max:g}")
        if not 0.0 <= self.gain <= MAX_GAIN:
            raise ValueError(f"gain: must be from 0 to {MAX_GAIN:g}, not {self.gain:g}")
        for key, priority in self.priorities.items():
            if not 0.0 <= priority <= MAX_GAIN:
                raise ValueError(f"priorities: that of {key!r} must be from 0 to {MAX_GAIN:g}, not {priority:g}")
        if not callable(self.method) and self.method not in ("cumulative", "weighted", "strongest", "power"):
            raise ValueError(f"method: unknown mixing method {self.method!r}")


class Voice(NamedTuple):
    """What one source does at the end of a frame.

    key: the source's identity from frame to frame.
    gains: shape (n_listeners,), or (n_listeners, 6) by frequency band; multiplied by `amplitude`.
    onset: seconds at which the signal begins, on the frames' clock, any real number.
    delays: seconds on the way to each listener, shape (n_listeners,), from 0 to 60; where the gain is 0 the delay does not matter.
    priority: weight in `weighted` mixing, from 0 to 1e6.
    """

    key: Hashable
    signal: Signal
    gains: FloatArray
    onset: float = 0.0
    amplitude: float = 1.0
    delays: FloatArray | None = None
    priority: float = 1.0


def sample_index(seconds: float, sample_rate: float) -> int:
    """Return the first sample n with n / sample_rate >= seconds, a millionth of a sample of rounding in `seconds` forgiven."""
    return math.ceil(seconds * sample_rate - _SNAP)


class Renderer:
    """Renders frames one after the other, a block of samples each.

    Gains and delays go in straight lines from frame to frame. A source seen for the first time fades in over that frame, unless its onset
    is not before the frame's start: then it begins at its onset, at full gain. A source no longer given fades out over the frame, and one
    whose signal changes fades from the old to the new.

    latency: samples by which the output lags, 0 unless a listener has a limiter.
    """

    def __init__(self, listeners: Sequence[ListenerMix], sample_rate: float = SAMPLE_RATE) -> None:
        if not 100.0 <= sample_rate <= 192_000.0:
            raise ValueError(f"sample_rate: must be from 100 to 192000, not {sample_rate:g}")
        self.listeners = tuple(listeners)
        self.sample_rate = float(sample_rate)
        s_max = np.array([listener.s_max for listener in self.listeners], dtype=np.float64)
        limited = np.array([listener.limiter for listener in self.listeners], dtype=bool)
        self._gain = np.array([listener.gain for listener in self.listeners], dtype=np.float64)[:, None]
        self._cut = np.where(limited, np.inf, s_max)[:, None]
        self._limiter = Limiter(s_max, self.sample_rate) if limited.any() else None
        self.latency = self._limiter.latency if self._limiter else 0
        self._weighted = [index for index, listener in enumerate(self.listeners) if listener.method == "weighted"]
        self._unsummed = _by_method(self.listeners)
        self._streams: dict[Hashable, _Stream] = {}
        self._next: int | None = None

    def reset(self) -> None:
        """Forget what was rendered: the next frame may be anywhere in time."""
        self._streams = {}
        self._next = None
        if self._limiter:
            self._limiter.reset()

    def render_frame(self, start: float, end: float, voices: Sequence[Voice]) -> FloatArray:
        """Return the samples n with start <= n / sample_rate < end (seconds, at most 60 apart), shape (n_listeners, n_samples).

        Gains reach those of `voices` at `end`. Frames follow each other without a gap, else call `reset` first.
        Raises ValueError that names the argument; the renderer is then as it was before.
        """
        frame = self._frame(start, end)
        parts = self._parts(frame, voices)
        kinds = sorted({part.stream.kind for part in parts})
        groups = [self._group([part for part in parts if part.stream.kind == kind]) for kind in kinds]
        block = self._mix([paths for group in groups for paths in _paths(frame, group)], frame.count)
        self._next = frame.last
        self._streams = {}
        for group in groups:
            delays = repeat(None) if group.delays is None else group.delays
            for (stream, voice, _), gains, delay in zip(group.parts, group.gains, delays, strict=False):
                if voice is not None:
                    stream.gains, stream.delays, stream.priority = gains, delay, voice.priority
                    self._streams[stream.key] = stream
        return self._limiter.process(block) if self._limiter else block

    def flush(self) -> FloatArray:
        """Return the last `latency` samples, shape (n_listeners, latency)."""
        empty = np.zeros((len(self.listeners), self.latency))
        return self._limiter.process(empty) if self._limiter else empty

    def _frame(self, start: float, end: float) -> _Frame:
        if not (-MAX_TIME <= start <= end <= MAX_TIME and end - start <= MAX_FRAME):
            raise ValueError(f"end: {end!r} must be 0 to {MAX_FRAME:g} seconds after start {start!r}, both within ±{MAX_TIME:g}")
        first, last = sample_index(start, self.sample_rate), sample_index(end, self.sample_rate)
        if self._next is not None and first != self._next:
            raise ValueError(f"start: {start!r} does not follow the last frame; reset the renderer before a jump")
        times = np.arange(first, last) / self.sample_rate
        return _Frame(start, end, first, last, times, (times - start) / (end - start) if last > first else times)

    def _parts(self, frame: _Frame, voices: Sequence[Voice]) -> list[_Part]:
        """Return the stream of each voice, then those that are replaced or left out."""
        parts = []
        fading = dict(self._streams)
        replaced = []
        for voice in voices:
            self._check(voice)
            stream = fading.pop(voice.key, None)
            begins = False
            if stream is None or not stream.plays(voice):
                begins = voice.onset >= frame.start and (stream is None or stream.onset != voice.onset)
                if stream is not None:
                    replaced.append(stream)
                stream = _Stream(voice, self.sample_rate)
            parts.append(_Part(stream, voice, begins))
        if len({voice.key for voice in voices}) < len(voices):
            keys = [voice.key for voice in voices]
            raise ValueError(f"voices: key {next(key for key in keys if keys.count(key) > 1)!r} is given twice")
        return parts + [_Part(stream, None, False) for stream in (*replaced, *fading.values())]

    def _check(self, voice: Voice) -> None:
        count = len(self.listeners)
        if voice.gains.shape not in ((count,), (count, BAND_COUNT)):
            raise ValueError(f"gains: those of {voice.key!r} have shape {voice.gains.shape}, not ({count},) or ({count}, {BAND_COUNT})")
        if voice.delays is not None and voice.delays.shape != (count,):
            raise ValueError(f"delays: those of {voice.key!r} have shape {voice.delays.shape}, not ({count},)")
        if not -MAX_GAIN <= voice.amplitude <= MAX_GAIN:
            raise ValueError(f"amplitude: that of {voice.key!r} must be within ±{MAX_GAIN:g}")
        if not -MAX_TIME <= voice.onset <= MAX_TIME:
            raise ValueError(f"onset: that of {voice.key!r} must be within ±{MAX_TIME:g} seconds")
        if not 0.0 <= voice.priority <= MAX_GAIN:
            raise ValueError(f"priority: that of {voice.key!r} must be from 0 to {MAX_GAIN:g}")

    def _group(self, parts: list[_Part]) -> _Group:
        """Return where the gains and delays of parts of one kind go in this frame. What listeners weigh has its weight in its gain."""
        shape = (len(parts), *parts[0].stream.gains.shape)
        gains = np.concatenate([part.stream.gains if part.voice is None else part.voice.gains for part in parts], dtype=np.float64)
        gains = gains.reshape(shape)
        within = np.abs(gains) <= MAX_GAIN
        if not within.all():
            key = parts[int(np.argmin(within.reshape(len(parts), -1).all(axis=1)))].stream.key
            raise ValueError(f"gains: those of {key!r} must be finite and within ±{MAX_GAIN:g}")
        gains = (gains.T * [0.0 if part.voice is None else part.voice.amplitude for part in parts]).T
        for listener in self._weighted:
            gains[:, listener] = (gains[:, listener].T * [self._weight(listener, part) for part in parts]).T
        before = np.concatenate([part.stream.gains for part in parts]).reshape(shape)
        begins = [part.begins for part in parts]
        before[begins] = gains[begins]
        if parts[0].stream.delays is None:
            return _Group(parts, before, gains, None, None)
        delays_before = np.array([part.stream.delays for part in parts])
        delays = np.array([part.stream.delays if part.voice is None else part.voice.delays for part in parts])
        within = ~_heard(gains) | ((delays >= 0.0) & (delays <= MAX_DELAY))
        if not within.all():
            key = parts[int(np.argmin(within.all(axis=1)))].stream.key
            raise ValueError(f"delays: those of {key!r} must be from 0 to {MAX_DELAY:g}")
        # The delay of a path that is not heard means nothing: it is taken from the frame's other end.
        delays = np.where(_heard(gains), delays, delays_before)
        return _Group(parts, before, gains, np.where(_heard(before), delays_before, delays), delays)

    def _weight(self, listener: int, part: _Part) -> float:
        priority = part.stream.priority if part.voice is None else part.voice.priority
        return self.listeners[listener].priorities.get(part.stream.key, priority)

    def _mix(self, groups: list[_DirectPaths | _DelayedPaths | _SteadyPaths], count: int) -> FloatArray:
        """Return the listeners' mixes, shape (n_listeners, count), cut at s_max where no limiter takes care of that."""
        total = groups[0].summed() if groups else np.zeros((len(self.listeners), count))
        for group in groups[1:]:
            total += group.summed()
        for method, listeners in self._unsummed:
            each = [group.at_listeners(listeners) for group in groups] or [np.empty((0, len(listeners), count))]
            voices = np.concatenate(each) if len(each) > 1 else each[0]
            if callable(method):
                weights = np.array([self._weight(listeners[0], part) for group in groups for part in group.parts])
                total[listeners[0]] = mixed(method, voices[:, 0], weights)
            else:
                total[listeners] = mixed(method, voices, np.ones(len(voices)))
        total *= self._gain
        np.minimum(total, self._cut, out=total)
        return np.maximum(total, -self._cut, out=total)


def bake(renderer: Renderer, frames: Iterable[tuple[float, float, Sequence[Voice]]]) -> FloatArray:
    """Return all samples of consecutive `frames` (start, end, voices), shape (n_listeners, n_samples), the renderer's latency taken out.

    But for that it is, sample for sample, what the same frames give when they are played.
    """
    renderer.reset()
    blocks = [renderer.render_frame(start, end, voices) for start, end, voices in frames]
    return np.concatenate([*blocks, renderer.flush()], axis=1)[:, renderer.latency :]


@dataclass(frozen=True, slots=True)
class _Frame:
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


class _Stream:
    """A voice from frame to frame: where its gains and delays stand, and samples rendered ahead.

    Ahead, because a few long runs cost less than many short ones; a sample depends on its own time alone, so they are the same.
    """

    __slots__ = (
        "_first", "_known", "delays", "end", "gains", "is_recorded", "key", "kind", "onset", "priority", "row_count", "sample_rate",
        "settled", "signal", "tone",
    )  # fmt: skip

    def __init__(self, voice: Voice, sample_rate: float) -> None:
        self.key = voice.key
        self.signal = voice.signal
        self.onset = voice.onset
        self.priority = voice.priority
        self.row_count = 1 if voice.gains.ndim == 1 else BAND_COUNT
        self.sample_rate = sample_rate
        self.gains = np.zeros_like(voice.gains)
        self.delays = voice.delays
        self.kind = voice.delays is not None, self.row_count
        self._first = 0
        self._known = np.empty((self.row_count, 0))
        tail = 0.0 if self.row_count == 1 else bank_reach(sample_rate) / sample_rate
        self.end = self.onset + self.signal.duration + tail
        self.settled = self.onset + tail
        self.tone = _steady_tone(self.signal, sample_rate)
        self.is_recorded = voice.delays is not None and _is_recorded(self.signal)

    def plays(self, voice: Voice) -> bool:
        """Whether `voice` is this one with other gains, delays or amplitude."""
        if self.onset != voice.onset or (self.delays is None) != (voice.delays is None) or self.gains.shape != voice.gains.shape:
            return False
        return self.signal is voice.signal or self.signal == voice.signal

    def is_steady(self, time: float) -> bool:
        """Whether what is heard from `time` on (seconds), in all bands, is one tone for ever."""
        return self.tone is not None and time >= self.settled

    def sounds(self, start: float, end: float) -> bool:
        """Whether there is anything of the signal from start to end (seconds)."""
        return self.onset < end and start < self.end

    def rows(self, first: int, last: int) -> FloatArray:
        """Return samples first to last - 1 of the signal, shape (1, n), or of its bands, shape (6, n)."""
        begin, known = self._first, self._first + self._known.shape[1]
        if not begin <= first <= known:
            begin = self._first = known = first // _CHUNK * _CHUNK
            self._known = np.empty((self.row_count, 0))
        if last > known:
            kept = max((first - _CHUNK) // _CHUNK * _CHUNK, begin)
            runs = [self._sampled(run, run + _CHUNK) for run in range(known, last, _CHUNK)]
            self._known = np.concatenate((self._known[:, kept - begin :], *runs), axis=1)
            self._first = kept
        return self._known[:, first - self._first : last - self._first]

    def _sampled(self, first: int, last: int) -> FloatArray:
        if self.row_count == 1:
            return self.signal.sample(first, last - first, self.sample_rate, self.onset)[None, :]
        reach = bank_reach(self.sample_rate)
        samples = self.signal.sample(first - reach, last - first + 2 * reach, self.sample_rate, self.onset)
        # The filters look ahead, but nothing may be felt before the onset.
        begun = np.arange(first, last) / self.sample_rate >= self.onset
        return split_bands(samples, self.sample_rate) * begun


class _Part(NamedTuple):
    """A stream in one frame. Without a voice it fades out; one that begins has its full gain from its onset on."""

    stream: _Stream
    voice: Voice | None
    begins: bool


@dataclass(frozen=True, slots=True)
class _Group:
    """Parts of one kind and their gains at a frame's start and end, shape (n_parts, n_listeners) or (n_parts, n_listeners, 6)."""

    parts: list[_Part]
    before: FloatArray
    gains: FloatArray
    delays_before: FloatArray | None
    delays: FloatArray | None

    def chosen(self, index: list[int]) -> _Group:
        """Return some of the parts."""
        if len(index) == len(self.parts):
            return self
        delays_before = None if self.delays_before is None else self.delays_before[index]
        delays = None if self.delays is None else self.delays[index]
        return _Group([self.parts[number] for number in index], self.before[index], self.gains[index], delays_before, delays)


class _DirectPaths:
    """What listeners get without delay: the same samples for all, times gains on a ramp, so a sum over voices is a matrix product."""

    def __init__(self, frame: _Frame, group: _Group) -> None:
        heard = np.any(_heard(group.before) | _heard(group.gains), axis=1).tolist()
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


class _DelayedPaths:
    """What listeners get along paths with a delay each: the signal at an earlier time, which moves as the delay changes."""

    def __init__(self, frame: _Frame, group: _Group) -> None:
        assert group.delays_before is not None and group.delays is not None
        heard = _heard(group.before) | _heard(group.gains)
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


class _SteadyPaths:
    """What listeners get of steady tones, along paths with bands or delays: a band's filter is a gain, and a delay a turn of phase."""

    def __init__(self, frame: _Frame, group: _Group) -> None:
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
            heard = _heard(group.before) | _heard(group.gains)
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


def _travelled(stream: _Stream, times: FloatArray, before: FloatArray, change: FloatArray, ramp: FloatArray) -> FloatArray:
    """Return a signal at `times`, shape (n_paths, n), times gains that go from `before`, shape (n_paths,), by `change` along the ramp."""
    values = stream.signal.at(times.ravel() - stream.onset, 1.0 / stream.sample_rate).reshape(times.shape)
    return (before[:, None] + change[:, None] * ramp) * values


def _travelled_between_samples(stream: _Stream, times: FloatArray, before: FloatArray, change: FloatArray, ramp: FloatArray) -> FloatArray:
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


def _by_method(listeners: Sequence[ListenerMix]) -> list[tuple[MixingMethod, list[int]]]:
    """Return the methods that need each voice by itself, and the listeners that mix by them; one at a time by custom methods."""
    groups: list[tuple[MixingMethod, list[int]]] = []
    for method in ("strongest", "power"):
        alike = [index for index, listener in enumerate(listeners) if listener.method == method]
        groups += [(method, alike)] if alike else []
    return groups + [(listener.method, [index]) for index, listener in enumerate(listeners) if callable(listener.method)]


def _paths(frame: _Frame, group: _Group) -> list[_DirectPaths | _DelayedPaths | _SteadyPaths]:
    """Return the paths of a group: those of steady tones by themselves where bands or delays make samples costly."""
    if group.delays is None and group.parts[0].stream.row_count == 1:
        return [_DirectPaths(frame, group)]
    longest = _longest_delays(group).tolist()
    steady = [frame.count > 0 and part.stream.is_steady(frame.start - delay) for part, delay in zip(group.parts, longest, strict=True)]
    paths: list[_DirectPaths | _DelayedPaths | _SteadyPaths] = []
    if any(steady):
        paths.append(_SteadyPaths(frame, group.chosen([index for index, is_steady in enumerate(steady) if is_steady])))
    if not all(steady):
        rest = group.chosen([index for index, is_steady in enumerate(steady) if not is_steady])
        paths.append(_DirectPaths(frame, rest) if group.delays is None else _DelayedPaths(frame, rest))
    return paths


def _longest_delays(group: _Group) -> FloatArray:
    """Return the longest delay of each part in the frame, of what is heard, shape (n_parts,)."""
    if group.delays is None or group.delays_before is None:
        return np.zeros(len(group.parts))
    heard = _heard(group.before) | _heard(group.gains)
    return np.asarray(np.where(heard, np.maximum(group.delays_before, group.delays), 0.0).max(axis=1, initial=0.0))


def _powers(base: FloatArray, count: int) -> FloatArray:
    """Return base^0 to base^(count - 1) in a new last axis."""
    powers = np.empty((*base.shape, count))
    powers[..., 0] = 1.0
    for degree in range(1, count):
        np.multiply(powers[..., degree - 1], base, out=powers[..., degree])
    return powers


def _tone_values(stream: _Stream) -> tuple[float, float, float, float]:
    """Return frequency, amplitude, phase and onset of a stream that is a steady tone."""
    tone = stream.tone
    assert tone is not None and isinstance(tone.frequency, float) and isinstance(tone.amplitude, float)
    return tone.frequency, tone.amplitude, tone.phase, stream.onset


def _is_recorded(signal: Signal) -> bool:
    """Whether a signal has a recording in it, whose values between samples are costly."""
    if isinstance(signal, Sampled):
        return True
    within = getattr(signal, "of", ())
    return any(_is_recorded(part) for part in (within if isinstance(within, tuple) else (within,)))


def _steady_tone(signal: Signal, sample_rate: float) -> Sine | None:
    """Return the signal where it is a tone of one frequency and strength that the samples can carry."""
    if type(signal) is not Sine or isinstance(signal.frequency, Automation) or isinstance(signal.amplitude, Automation):
        return None
    return signal if signal.frequency < sample_rate / 2 else None


def _heard(gains: FloatArray) -> BoolArray:
    """Return where a voice reaches a listener, shape (n_parts, n_listeners)."""
    return np.asarray(gains != 0.0 if gains.ndim == 2 else (gains != 0.0).any(axis=2))
