"""Voices: the signals of sources, and their samples rendered ahead of the frames."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..scene.bands import BAND_COUNT
from ..signals import Automation, Sampled, Signal, Sine
from .filter_bank import bank_reach, split_bands

_CHUNK = 4096
"""Samples of a signal are rendered in runs that begin at multiples of this, so that they are
bit-identical for any division into frames."""
_BRIEF = 2 * _CHUNK
"""Signals of at most this many samples are rendered as a whole, for the same reason."""
_TOGETHER = 16
"""Most signals that are rendered at once: enough to outweigh the overhead, few enough for the
processor's cache."""


class Voice(NamedTuple):
    """The state of one source at the end of a frame.

    key: the source's identity from frame to frame. gains: shape (n_listeners,), or (n_listeners, 6)
    by frequency band; multiplied by `amplitude`. onset: seconds at which the signal begins, on the
    frames' clock, any real number. delays: seconds on the way to each listener, shape
    (n_listeners,), from 0 to 60; where the gain is 0 the delay does not matter. priority: weight in
    `weighted` mixing, 0 or more.
    """

    key: Hashable
    signal: Signal
    gains: FloatArray
    onset: float = 0.0
    amplitude: float = 1.0
    delays: FloatArray | None = None
    priority: float = 1.0


class Stream:
    """A voice from frame to frame, with samples of its signal rendered ahead.

    Rendering ahead is cheaper in a few long runs, and changes nothing, because a sample depends
    only on its own time.

    kind: whether it has delays, and its number of bands, 1 or 6. end: when the signal is over [s].
    settled: time from which all bands of a steady tone are steady [s], as their filters reach ahead
    and back. tone: the signal where it is a steady tone, else None. is_brief: short enough to be
    rendered as a whole, see `sample_brief`. Samples `_first` to `_last` - 1 are in `_samples`,
    shape (1 or 6, n).
    """

    def __init__(self, voice: Voice, sample_rate: float) -> None:
        self.key = voice.key
        self.signal = voice.signal
        self.onset = voice.onset
        self.priority = voice.priority
        self.row_count = 1 if voice.gains.ndim == 1 else BAND_COUNT
        self.sample_rate = sample_rate
        self.kind = voice.delays is not None, self.row_count
        self._first = self._last = 0
        self._samples = np.empty((self.row_count, 0))
        tail = 0.0 if self.row_count == 1 else bank_reach(sample_rate) / sample_rate
        self.end = self.onset + self.signal.duration + tail
        self.settled = self.onset + tail
        self.tone = steady_tone(self.signal, sample_rate)
        self.is_recorded = voice.delays is not None and _is_recorded(self.signal)
        self.is_brief = (self.end - self.onset) * sample_rate <= _BRIEF

    def plays(self, voice: Voice) -> bool:
        """Whether `voice` is this one with other gains, delays or amplitude."""
        has_delays, bands = self.kind
        if (
            self.onset != voice.onset
            or has_delays is (voice.delays is None)
            or (bands == 1) is not (voice.gains.ndim == 1)
        ):
            return False
        return self.signal is voice.signal or self.signal == voice.signal

    def is_steady(self, time: float) -> bool:
        """Whether the signal is one constant tone in all bands from `time` [s] on."""
        return self.tone is not None and time >= self.settled

    def sounds(self, start: float, end: float) -> bool:
        """Whether the signal is active between start and end [s]."""
        return self.onset < end and start < self.end

    def rows(self, first: int, last: int) -> FloatArray:
        """Return samples first to last - 1 of the signal, shape (1, n), or of its bands, shape (6,
        n)."""
        if self.is_brief and self._first == self._last:
            sample_brief([self])
        begin, known = self._first, self._last
        if begin <= first and last <= known:
            return self._samples[:, first - begin : last - begin]
        if self.is_brief:
            rows = np.zeros((self.row_count, last - first))
            inside = self._samples[:, max(first - begin, 0) : max(last - begin, 0)]
            rows[:, max(begin - first, 0) :][:, : inside.shape[1]] = inside
            return rows
        if not begin <= first <= known:
            begin = known = self._first = self._last = first // _CHUNK * _CHUNK
            self._samples = np.empty((self.row_count, 0))
        if last > known:
            kept = max((first - _CHUNK) // _CHUNK * _CHUNK, begin)
            runs = [self._sampled(run, run + _CHUNK) for run in range(known, last, _CHUNK)]
            self._samples = np.concatenate((self._samples[:, kept - begin :], *runs), axis=1)
            self._first = kept
            self._last = kept + self._samples.shape[1]
        return self._samples[:, first - self._first : last - self._first]

    def _sampled(self, first: int, last: int) -> FloatArray:
        if self.row_count == 1:
            return self.signal.sample(first, last - first, self.sample_rate, self.onset)[None, :]
        rate = self.sample_rate
        reach = bank_reach(self.sample_rate)
        bands = split_bands(
            self.signal.sample(first - reach, last - first + 2 * reach, rate, self.onset), rate
        )
        # The output is 0 before the onset, although the filters look ahead, and after the end.
        times = np.arange(first, last) / rate
        return bands * ((times >= self.onset) & (times < self.end))


def sample_brief(streams: Sequence[Stream]) -> None:
    """Render the brief ones among `streams` that have no samples yet, up to `_TOGETHER` of the same
    signal at once."""
    alike: dict[int, list[Stream]] = {}
    for stream in streams:
        if stream.is_brief and stream._first == stream._last:
            alike.setdefault(id(stream.signal), []).append(stream)
    for some in [
        every[k : k + _TOGETHER]
        for every in alike.values()
        for k in range(0, len(every), _TOGETHER)
    ]:
        signal = some[0].signal
        rate = some[0].sample_rate
        reach = bank_reach(some[0].sample_rate)
        onset = np.array([stream.onset for stream in some])
        first = np.ceil(onset * rate)
        times = (np.arange(int(signal.duration * rate) + 1) + first[:, None]) / rate - onset[
            :, None
        ]
        samples = signal.at(times.reshape(-1), 1.0 / rate).reshape(times.shape)
        for stream, number, row in zip(some, first.tolist(), samples, strict=True):
            stream._samples = row[None, :]
            if stream.row_count > 1:
                padded = np.zeros(len(row) + 3 * reach)  # the filters still hear it for a while
                padded[reach : reach + len(row)] = row
                stream._samples = split_bands(padded, rate)
            stream._first = int(number)
            stream._last = int(number) + stream._samples.shape[1]


def _is_recorded(signal: Signal) -> bool:
    """Whether a signal has a recording in it, whose values between samples are costly."""
    if isinstance(signal, Sampled):
        return True
    within = getattr(signal, "of", ())
    return any(_is_recorded(part) for part in (within if isinstance(within, tuple) else (within,)))


def steady_tone(signal: Signal, sample_rate: float) -> Sine | None:
    """Return the signal where it is a tone of one frequency and strength that the samples can
    carry."""
    if (
        type(signal) is not Sine
        or isinstance(signal.frequency, Automation)
        or isinstance(signal.amplitude, Automation)
    ):
        return None
    return signal if signal.frequency < sample_rate / 2 else None
