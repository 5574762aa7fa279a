"""Signals times gains: one block of samples per listener, frame after frame.

A signal is a function of time, so that nothing of it has to be kept from block to block: a voice is looked up where the frame needs it,
delayed paths at their own time, the bands' symmetric filters ahead of it. What is kept is where each gain and delay stood.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .bands import BAND_COUNT
from .filter_bank import bank_reach, split_bands
from .mixing import Limiter, MixingMethod, mixed, saturated
from .signals import Signal
from .signals.interpolation import ZERO_CROSSINGS, interpolate

Array = NDArray[np.float64]

SAMPLE_RATE = 8000.0
MAX_GAIN = 1e6
"""Largest magnitude of a gain times its amplitude."""
MAX_DELAY = 60.0
"""Seconds."""
MAX_TIME = 1e6
"""Seconds before and after 0 within which frames lie."""
_CHUNK = 2048
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


@dataclass(frozen=True, slots=True)
class Voice:
    """What one source does at the end of a frame.

    key: the source's identity from frame to frame.
    gains: shape (n_listeners,), or (n_listeners, 6) by frequency band; multiplied by `amplitude`.
    onset: seconds at which the signal begins, on the frames' clock, any real number.
    delays: seconds on the way to each listener, shape (n_listeners,), from 0 to 60; where the gain is 0 the delay does not matter.
    priority: weight in `weighted` mixing, from 0 to 1e6.
    """

    key: Hashable
    signal: Signal
    gains: Array
    onset: float = 0.0
    amplitude: float = 1.0
    delays: Array | None = None
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
        self._unsummed = [index for index, listener in enumerate(self.listeners) if listener.method not in ("cumulative", "weighted")]
        self._streams: dict[Hashable, _Stream] = {}
        self._next: int | None = None

    def reset(self) -> None:
        """Forget what was rendered: the next frame may be anywhere in time."""
        self._streams = {}
        self._next = None
        if self._limiter:
            self._limiter.reset()

    def render_frame(self, start: float, end: float, voices: Sequence[Voice]) -> Array:
        """Return the samples n with start <= n / sample_rate < end (seconds), shape (n_listeners, n_samples).

        Gains reach those of `voices` at `end`. Frames follow each other without a gap, else call `reset` first.
        Raises ValueError that names the argument; the renderer is then as it was before.
        """
        frame = self._frame(start, end)
        moves = self._moves(frame, voices)
        block = self._mix(frame, [move for move in moves if move.is_heard(frame)])
        self._next = frame.last
        self._streams = {}
        for move in moves:
            if move.stays:
                move.stream.gains, move.stream.delays, move.stream.priority = move.gains, move.delays, move.priority
                self._streams[move.stream.key] = move.stream
        return self._limiter.process(block) if self._limiter else block

    def flush(self) -> Array:
        """Return the last `latency` samples, shape (n_listeners, latency)."""
        empty = np.zeros((len(self.listeners), self.latency))
        return self._limiter.process(empty) if self._limiter else empty

    def _frame(self, start: float, end: float) -> _Frame:
        if not -MAX_TIME <= start <= end <= MAX_TIME:
            raise ValueError(f"end: {end!r} must not be before start {start!r}, and both be within ±{MAX_TIME:g} seconds")
        first, last = sample_index(start, self.sample_rate), sample_index(end, self.sample_rate)
        if self._next is not None and first != self._next:
            raise ValueError(f"start: {start!r} does not follow the last frame; reset the renderer before a jump")
        times = np.arange(first, last) / self.sample_rate
        return _Frame(start, end, first, last, times, (times - start) / (end - start) if last > first else times)

    def _moves(self, frame: _Frame, voices: Sequence[Voice]) -> list[_Move]:
        """Return where gains and delays go in this frame: those of the voices, then of what is replaced or left out."""
        moves: list[_Move] = []
        left = dict(self._streams)
        keys = set()
        replaced = []
        for voice in voices:
            if voice.key in keys:
                raise ValueError(f"voices: key {voice.key!r} is given twice")
            keys.add(voice.key)
            gains = self._gains(voice)
            stream = left.pop(voice.key, None)
            if stream is not None and stream.plays(voice):
                before, delays_before = stream.gains, stream.delays
            else:
                begins = voice.onset >= frame.start and (stream is None or stream.onset != voice.onset)
                before, delays_before = gains if begins else np.zeros_like(gains), None
                if stream is not None:
                    replaced.append(stream)
                stream = _Stream(voice, self.sample_rate)
            if voice.delays is None:
                moves.append(_Move(stream, before, gains, None, None, voice.priority, True))
            else:
                delays_before, delays = self._delays(voice, before, gains, delays_before)
                moves.append(_Move(stream, before, gains, delays_before, delays, voice.priority, True))
        for stream in (*replaced, *left.values()):
            silent = np.zeros_like(stream.gains)
            moves.append(_Move(stream, stream.gains, silent, stream.delays, stream.delays, stream.priority, False))
        return moves

    def _gains(self, voice: Voice) -> Array:
        """Return the voice's gains times its amplitude, and times its priority where a listener weighs it."""
        count = len(self.listeners)
        gains = voice.gains * np.float64(voice.amplitude)
        if gains.shape != (count,) and gains.shape != (count, BAND_COUNT):
            raise ValueError(f"gains: those of {voice.key!r} have shape {gains.shape}, not ({count},) or ({count}, {BAND_COUNT})")
        if not (np.abs(gains) <= MAX_GAIN).all():
            raise ValueError(f"gains: those of {voice.key!r} times its amplitude must be within ±{MAX_GAIN:g}")
        if not -MAX_TIME <= voice.onset <= MAX_TIME:
            raise ValueError(f"onset: that of {voice.key!r} must be within ±{MAX_TIME:g} seconds")
        if not 0.0 <= voice.priority <= MAX_GAIN:
            raise ValueError(f"priority: that of {voice.key!r} must be from 0 to {MAX_GAIN:g}")
        for index in self._weighted:
            gains[index] *= self._weight(index, voice.key, voice.priority)
        return gains

    def _delays(self, voice: Voice, before: Array, gains: Array, delays_before: Array | None) -> tuple[Array, Array]:
        """Return the delays at the frame's two ends. Where nothing is heard at one end, the delay is that of the other."""
        delays = np.where(_heard(gains), voice.delays, np.nan if delays_before is None else delays_before)
        delays_before = np.where(_heard(before), delays if delays_before is None else delays_before, delays)
        audible = _heard(gains) | _heard(before)
        if delays.shape != (len(self.listeners),) or not ((delays >= 0.0) & (delays <= MAX_DELAY))[audible].all():
            raise ValueError(f"delays: those of {voice.key!r} must be {len(self.listeners)} numbers from 0 to {MAX_DELAY:g}")
        return delays_before, delays

    def _weight(self, listener: int, key: Hashable, priority: float) -> float:
        return self.listeners[listener].priorities.get(key, priority)

    def _mix(self, frame: _Frame, moves: list[_Move]) -> Array:
        """Return the listeners' mixes, shape (n_listeners, n), cut at s_max where no limiter takes care of that."""
        direct = [move for move in moves if move.delays is None]
        rows = np.concatenate([np.empty((0, frame.count)), *(move.stream.rows(frame.first, frame.last) for move in direct)])
        before = np.concatenate([np.empty((0, len(self.listeners))), *(_by_row(move.before) for move in direct)])
        change = np.concatenate([np.empty((0, len(self.listeners))), *(_by_row(move.gains) for move in direct)]) - before
        rising = rows * frame.ramp
        total = before.T @ rows + change.T @ rising
        delayed = [(move, _delayed(frame, move)) for move in moves if move.delays is not None]
        for _, paths in delayed:
            total += paths
        for index in self._unsummed:
            ramped = rows * before[:, index, None] + rising * change[:, index, None]
            begins = np.cumsum([0, *(move.stream.row_count for move in direct)])[:-1]
            summed = np.add.reduceat(ramped, begins) if direct else ramped
            voices = np.concatenate((summed, *(paths[index][None] for _, paths in delayed)))
            order = [*direct, *(move for move, _ in delayed)]
            weights = np.array([self._weight(index, move.stream.key, move.priority) for move in order])
            total[index] = mixed(self.listeners[index].method, voices, weights)
        return saturated(total * self._gain, self._cut)


def bake(renderer: Renderer, frames: Iterable[tuple[float, float, Sequence[Voice]]]) -> Array:
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
    times: Array
    ramp: Array

    @property
    def count(self) -> int:
        return self.last - self.first


class _Stream:
    """A voice from frame to frame: where its gains and delays stand, and samples rendered ahead.

    Ahead, because a few long runs cost less than many short ones; a sample depends on its own time alone, so they are the same.
    """

    __slots__ = ("_ahead", "_end", "_first", "delays", "gains", "key", "onset", "priority", "row_count", "sample_rate", "signal")

    def __init__(self, voice: Voice, sample_rate: float) -> None:
        self.key = voice.key
        self.signal = voice.signal
        self.onset = voice.onset
        self.priority = voice.priority
        self.row_count = 1 if voice.gains.ndim == 1 else BAND_COUNT
        self.sample_rate = sample_rate
        self.gains = np.zeros_like(voice.gains)
        self.delays = voice.delays
        self._first = 0
        self._ahead = np.empty((self.row_count, 0))
        tail = 0 if self.row_count == 1 else bank_reach(sample_rate) / sample_rate
        self._end = self.onset + self.signal.duration + tail

    def plays(self, voice: Voice) -> bool:
        """Whether `voice` is this one with other gains, delays or amplitude."""
        return (
            self.onset == voice.onset
            and (self.signal is voice.signal or self.signal == voice.signal)
            and (self.delays is None) == (voice.delays is None)
            and self.gains.shape == voice.gains.shape
        )

    def sounds(self, start: float, end: float) -> bool:
        """Whether there is anything of the signal from start to end (seconds)."""
        return self.onset < end and start < self._end

    def rows(self, first: int, last: int) -> Array:
        """Return samples first to last - 1 of the signal, shape (1, n), or of its bands, shape (6, n)."""
        known = self._first + self._ahead.shape[1]
        if not self._first <= first <= known:
            self._first = known = first
            self._ahead = np.empty((self.row_count, 0))
        if last > known:
            end = min(self._end * self.sample_rate + 1.0, float(last + _CHUNK))
            more = self._sampled(known, max(last, math.ceil(end)))
            self._ahead = np.concatenate((self._ahead[:, first - self._first :], more), axis=1)
            self._first = first
        return self._ahead[:, first - self._first : last - self._first]

    def _sampled(self, first: int, last: int) -> Array:
        if self.row_count == 1:
            return self.signal.sample(first, last - first, self.sample_rate, self.onset)[None, :]
        reach = bank_reach(self.sample_rate)
        samples = self.signal.sample(first - reach, last - first + 2 * reach, self.sample_rate, self.onset)
        # The filters look ahead, but nothing may be felt before the onset.
        begun = np.arange(first, last) / self.sample_rate >= self.onset
        return split_bands(samples, self.sample_rate) * begun

    def at(self, times: Array) -> Array:
        """Return the signal, shape (1, n), or its bands, shape (6, n), at any `times` (seconds on the frames' clock)."""
        if self.row_count == 1:
            return self.signal.at(times - self.onset, 1.0 / self.sample_rate)[None, :]
        positions = times * self.sample_rate
        first = math.floor(float(np.min(positions))) - ZERO_CROSSINGS
        last = math.ceil(float(np.max(positions))) + ZERO_CROSSINGS + 1
        return interpolate(self.rows(first, last), positions - first) * (times >= self.onset)


@dataclass(frozen=True, slots=True)
class _Move:
    """The gains and delays of a stream at a frame's start and end."""

    stream: _Stream
    before: Array
    gains: Array
    delays_before: Array | None
    delays: Array | None
    priority: float
    stays: bool

    def is_heard(self, frame: _Frame) -> bool:
        """Whether anything of it reaches a listener in this frame."""
        if not (self.before.any() or self.gains.any()):
            return False
        if self.delays is None or self.delays_before is None:
            return self.stream.sounds(frame.start, frame.end)
        return self.stream.sounds(frame.start - max(np.nanmax(self.delays), np.nanmax(self.delays_before)), frame.end)


def _delayed(frame: _Frame, move: _Move) -> Array:
    """Return what each listener gets of a voice along its own delay, shape (n_listeners, n)."""
    assert move.delays is not None and move.delays_before is not None
    paths = np.zeros((len(move.delays), frame.count))
    if frame.count == 0:
        return paths
    for index in np.flatnonzero(_heard(move.before) | _heard(move.gains)):
        delay = move.delays_before[index] + (move.delays[index] - move.delays_before[index]) * frame.ramp
        before, gains = np.atleast_1d(move.before[index]), np.atleast_1d(move.gains[index])
        ramped = before[:, None] + (gains - before)[:, None] * frame.ramp
        paths[index] = (ramped * move.stream.at(frame.times - delay)).sum(axis=0)
    return paths


def _heard(gains: Array) -> NDArray[np.bool_]:
    """Return for which listeners, shape (n_listeners,), there is a gain."""
    return np.asarray(gains != 0.0 if gains.ndim == 1 else (gains != 0.0).any(axis=1))


def _by_row(gains: Array) -> Array:
    """Return gains by listener (and band) as one row per row of samples, shape (rows, n_listeners)."""
    return gains[None, :] if gains.ndim == 1 else gains.T
