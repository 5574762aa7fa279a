"""Signals times gains: one block of samples per listener, frame after frame.

A signal is a function of time and keeps no state between blocks: delayed paths are evaluated at
their own time, the symmetric filters of bands ahead of it. Only gains and delays are kept from
frame to frame.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray
from ..frozen import frozen
from .gains import FrameSamples
from .groups import MAX_GAIN, MAX_TIME, Groups
from .limiter import Limiter
from .mixing import MixingMethod, checked_method, mixed
from .paths import DelayedPaths, DirectPaths, SteadyPaths, paths_of
from .voices import Voice

SAMPLE_RATE = 8000.0
MAX_FRAME = 60.0
"""Longest frame [s]."""
_SNAP = 1e-6


@frozen
class ListenerMix:
    """The mixing settings of a listener.

    s_max: the largest magnitude of a sample, > 0.
    limiter: attenuate smoothly (Limiter) instead of clipping at s_max.
    """

    name: str
    method: MixingMethod = "cumulative"
    s_max: float = 1.0
    limiter: bool = False

    def __post_init__(self) -> None:
        if not 0.0 < self.s_max <= MAX_GAIN:
            raise ValueError(f"s_max: must be above 0 and at most {MAX_GAIN:g}, not {self.s_max:g}")
        if not callable(self.method):
            checked_method(self.method)


def checked_rate(sample_rate: float) -> float:
    """A rate at which samples can be rendered [Hz]. Raises ValueError."""
    if not 100.0 <= sample_rate <= 192_000.0:
        raise ValueError(f"sample_rate: must be from 100 to 192000, not {sample_rate:g}")
    return float(sample_rate)


def sample_index(seconds: float, sample_rate: float) -> int:
    """Return the first sample n with n / sample_rate >= seconds, a millionth of a sample of
    rounding in `seconds` forgiven."""
    return math.ceil(seconds * sample_rate - _SNAP)


class Renderer:
    """Renders frames one after the other, a block of samples each.

    Gains and delays go in straight lines from frame to frame, those of gains smoothed (see
    `core.render.gains`). A source seen for the first time fades in over that frame, unless its
    onset is not before the frame's start: then it begins at its onset, at full gain. A source no
    longer given fades out over the frame, and one whose signal changes fades from the old to the
    new.

    latency: samples by which the output lags, 0 unless a listener has a limiter.
    """

    def __init__(self, listeners: Sequence[ListenerMix], sample_rate: float = SAMPLE_RATE) -> None:
        self.listeners = tuple(listeners)
        self.sample_rate = checked_rate(sample_rate)
        s_max = np.array([listener.s_max for listener in self.listeners], dtype=np.float64)
        limited = np.array([listener.limiter for listener in self.listeners], dtype=bool)
        self._cut = np.where(limited, np.inf, s_max)[:, None]
        self._limiter = Limiter(s_max, self.sample_rate) if limited.any() else None
        self.latency = self._limiter.latency if self._limiter else 0
        self._unsummed = _by_method(self.listeners)
        weighted = [
            index for index, listener in enumerate(self.listeners) if listener.method == "weighted"
        ]
        self._groups = Groups(len(self.listeners), self.sample_rate, weighted)
        self._next: int | None = None

    def reset(self) -> None:
        """Drop all state: the next frame may be at any time."""
        self._groups.reset()
        self._next = None
        if self._limiter:
            self._limiter.reset()

    def render_frame(self, start: float, end: float, voices: Sequence[Voice]) -> FloatArray:
        """Return the samples n with start <= n / sample_rate < end (seconds, at most 60 apart),
        shape (n_listeners, n_samples).

        Gains change along straight lines and reach those of `voices` at `end`. Frames follow each
        other without a gap, else call `reset` first. Raises ValueError that names the argument; the
        renderer is then as it was before.
        """
        frame = self._frame(start, end)
        groups = self._groups.follow(frame, voices)
        block = self._mix(
            [paths for group in groups for paths in paths_of(frame, group)], frame.count
        )
        self._next = frame.last
        self._groups.advance(frame, groups)
        return self._limiter.process(block) if self._limiter else block

    def _frame(self, start: float, end: float) -> FrameSamples:
        """Return the times of a frame's samples. Raises ValueError if it does not follow the last
        frame, or is too long."""
        if not (-MAX_TIME <= start <= end <= MAX_TIME and end - start <= MAX_FRAME):
            raise ValueError(
                f"end: {end!r} must be 0 to {MAX_FRAME:g} seconds after start {start!r}, both "
                f"within ±{MAX_TIME:g}"
            )
        first = sample_index(start, self.sample_rate)
        last = sample_index(end, self.sample_rate)
        if self._next is not None and first != self._next:
            raise ValueError(
                f"start: {start!r} does not follow the last frame; reset the renderer before a jump"
            )
        times = np.arange(first, last) / self.sample_rate
        return FrameSamples(
            start,
            end,
            first,
            last,
            times,
            (times - start) / (end - start) if last > first else times,
        )

    def _mix(
        self, groups: list[DirectPaths | DelayedPaths | SteadyPaths], count: int
    ) -> FloatArray:
        """Return the listeners' mixes, shape (n_listeners, count), clipped at s_max for listeners
        without a limiter."""
        total = np.zeros((len(self.listeners), count))
        if sum(len(listeners) for _, listeners in self._unsummed) < len(self.listeners):
            for group in groups:
                total += group.summed()
        for method, listeners in self._unsummed:
            each = [group.at_listeners(listeners) for group in groups] or [
                np.empty((0, len(listeners), count))
            ]
            voices = np.concatenate(each) if len(each) > 1 else each[0]
            if callable(method):
                weights = np.array([weight for group in groups for weight in group.group.weights()])
                total[listeners[0]] = mixed(method, voices[:, 0], weights)
            else:
                total[listeners] = mixed(method, voices, np.ones(len(voices)))
        np.minimum(total, self._cut, out=total)
        return np.maximum(total, -self._cut, out=total)


def _by_method(listeners: Sequence[ListenerMix]) -> list[tuple[MixingMethod, list[int]]]:
    """Return the methods that need each voice by itself, and the listeners that mix by them; one at
    a time by custom methods."""
    groups: list[tuple[MixingMethod, list[int]]] = []
    for method in ("strongest", "power"):
        alike = [index for index, listener in enumerate(listeners) if listener.method == method]
        groups += [(method, alike)] if alike else []
    return groups + [
        (listener.method, [index])
        for index, listener in enumerate(listeners)
        if callable(listener.method)
    ]
