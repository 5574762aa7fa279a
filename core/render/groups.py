"""The voices of consecutive frames, grouped by what their paths have: delays or none, one gain or
one per band."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..declaration import MOST
from ..frozen import frozen
from ..scene.bands import BAND_COUNT
from .gains import Bend, FrameSamples, Gains, any_gain
from .voices import Stream, Voice

MAX_GAIN = 1e30
"""Largest magnitude of a gain, of an amplitude and of a priority: their products with signals
remain finite, and the squares of these."""
MAX_DELAY = 60.0
"""Seconds."""
MAX_TIME = 1e6
"""Seconds before and after 0 within which frames lie."""
MAX_ONSET = MOST
"""Seconds before and after 0 within which signals begin."""


@frozen
class Group:
    """Streams of one kind in a frame with their voices, None where a stream fades out; those with
    voices come first.

    audible: shape (n_streams, n_listeners). delays_before, delays: seconds at the frame's start and
    end, of the same shape; None without.
    """

    streams: list[Stream]
    voices: list[Voice | None]
    gains: Gains
    audible: BoolArray
    delays_before: FloatArray | None = None
    delays: FloatArray | None = None

    def chosen(self, index: list[int]) -> Group:
        """Return some of the streams."""
        if len(index) == len(self.streams):
            return self
        return Group(
            [self.streams[number] for number in index],
            [self.voices[number] for number in index],
            self.gains.chosen(index),
            self.audible[index],
            None if self.delays_before is None else self.delays_before[index],
            None if self.delays is None else self.delays[index],
        )

    def longest_delays(self) -> FloatArray:
        """Return the longest delay of each stream on its audible paths, shape (n_streams,)."""
        if self.delays is None or self.delays_before is None:
            return np.zeros(len(self.streams))
        longest = np.maximum(self.delays_before, self.delays)
        return np.asarray(np.where(self.audible, longest, 0.0).max(axis=1, initial=0.0))

    def weights(self) -> list[float]:
        """Return the weights in a mix by priorities."""
        return _weights(self.streams, self.voices)


class _Last(NamedTuple):
    """Streams of one kind with their gains and delays in the last frame, row by row."""

    streams: list[Stream]
    gains: Gains
    delays: FloatArray | None


class Groups:
    """Follows voices from frame to frame. weighted: the listeners whose gains include
    priorities."""

    def __init__(self, listener_count: int, sample_rate: float, weighted: Sequence[int]) -> None:
        self._listener_count = listener_count
        self._sample_rate = sample_rate
        self._weighted = weighted
        self.reset()

    def reset(self) -> None:
        """Drop all voices."""
        self._streams: dict[Hashable, Stream] = {}
        self._tails: list[Stream] = []
        self._last: dict[tuple[bool, int], _Last] = {}

    def follow(self, frame: FrameSamples, voices: Sequence[Voice]) -> list[Group]:
        """Return the groups of a frame, without a change of the state: `advance` does that. Raises
        ValueError that names the argument."""
        self._check(voices)
        streams, begins = self._playing(frame, voices)
        playing = set(streams)
        silent = [
            stream for stream in (*self._streams.values(), *self._tails) if stream not in playing
        ]
        streams += silent
        given: list[Voice | None] = [*voices, *[None] * len(silent)]
        groups = []
        for kind in sorted({stream.kind for stream in streams}):
            rows = [row for row, stream in enumerate(streams) if stream.kind == kind]
            first = [number for number, row in enumerate(rows) if row in begins]
            groups.append(
                self._group(
                    frame, [streams[row] for row in rows], [given[row] for row in rows], first
                )
            )
        return groups

    def advance(self, frame: FrameSamples, groups: Sequence[Group]) -> None:
        """Go on to the next frame: keep voices, and streams that still fade out."""
        self._streams = {}
        self._tails = []
        self._last = {}
        for group in groups:
            self._last[group.streams[0].kind] = _Last(group.streams, group.gains, group.delays)
            for row, (stream, voice) in enumerate(zip(group.streams, group.voices, strict=True)):
                if voice is not None:
                    stream.priority = voice.priority
                    self._streams[stream.key] = stream
                elif group.gains.is_fading(row, frame.end):
                    self._tails.append(stream)

    def _playing(
        self, frame: FrameSamples, voices: Sequence[Voice]
    ) -> tuple[list[Stream], list[int]]:
        """Return the stream of each voice, and the rows of those that begin within the frame, which
        have their full gain at once instead of fading in."""
        streams = []
        begins = []
        keys = {voice.key for voice in voices}
        if len(keys) < len(voices):
            given = [voice.key for voice in voices]
            raise ValueError(
                f"voices: key {next(key for key in given if given.count(key) > 1)!r} is given twice"
            )
        for row, voice in enumerate(voices):
            stream = self._streams.get(voice.key)
            if stream is None or not stream.plays(voice):
                if voice.onset >= frame.start and (stream is None or stream.onset != voice.onset):
                    begins.append(row)
                stream = Stream(voice, self._sample_rate)
            streams.append(stream)
        return streams, begins

    def _check(self, voices: Sequence[Voice]) -> None:
        plain = (self._listener_count,)
        banded = self._listener_count, BAND_COUNT
        for key, _, gains, onset, amplitude, delays, priority in voices:
            if gains.shape != plain and gains.shape != banded:
                raise ValueError(
                    f"gains: those of {key!r} have shape {gains.shape}, not {plain} or {banded}"
                )
            if delays is not None and delays.shape != plain:
                raise ValueError(f"delays: those of {key!r} have shape {delays.shape}, not {plain}")
            if not -MAX_GAIN <= amplitude <= MAX_GAIN:
                raise ValueError(f"amplitude: that of {key!r} must be within ±{MAX_GAIN:g}")
            if not -MAX_ONSET <= onset <= MAX_ONSET:
                raise ValueError(f"onset: that of {key!r} must be within ±{MAX_ONSET:g} seconds")
            if not 0.0 <= priority <= MAX_GAIN:
                raise ValueError(f"priority: that of {key!r} must be from 0 to {MAX_GAIN:g}")

    def _group(
        self,
        frame: FrameSamples,
        streams: list[Stream],
        voices: list[Voice | None],
        begins: list[int],
    ) -> Group:
        end = self._final_gains(streams, voices)
        start, slope, bends = self._entering(frame, streams, end.shape)
        if begins:
            start[begins] = end[begins]
        gains = Gains.of_frame(frame, start, end, slope, bends)
        if not streams[0].kind[0]:
            return Group(streams, voices, gains, gains.audible())
        delays_before, delays = self._delays(streams, voices)
        open_at_end = any_gain(end)
        within = ~open_at_end | ((delays >= 0.0) & (delays <= MAX_DELAY))
        if not within.all():
            key = streams[int(np.argmin(within.all(axis=1)))].key
            raise ValueError(f"delays: those of {key!r} must be from 0 to {MAX_DELAY:g}")
        # The delay of an inaudible path is arbitrary and taken from the other end of the frame.
        delays = np.where(open_at_end, delays, delays_before)
        delays_before = np.where(
            any_gain(start, slope, *(bend.amount for bend in bends)), delays_before, delays
        )
        return Group(streams, voices, gains, gains.audible(), delays_before, delays)

    def _final_gains(self, streams: Sequence[Stream], voices: Sequence[Voice | None]) -> FloatArray:
        """Return the gains at the frame's end, with amplitudes and weights; 0 of streams without a
        voice, which fade out."""
        given = [voice for voice in voices if voice is not None]
        bands = streams[0].kind[1]
        shape = (self._listener_count,) if bands == 1 else (self._listener_count, bands)
        silent = [np.zeros(shape)] * (len(voices) - len(given))
        end = np.concatenate([voice.gains for voice in given] + silent, dtype=np.float64).reshape(
            len(voices), *shape
        )
        within = np.abs(end) <= MAX_GAIN
        if not within.all():
            key = streams[int(np.argmin(within.reshape(len(voices), -1).all(axis=1)))].key
            raise ValueError(f"gains: those of {key!r} must be finite and within ±{MAX_GAIN:g}")
        amplitudes = [voice.amplitude for voice in given]
        if amplitudes.count(1.0) < len(given):
            end[: len(given)].T[...] *= amplitudes
        for listener in self._weighted:
            end[:, listener].T[...] *= _weights(streams, voices)
        return end

    def _entering(
        self, frame: FrameSamples, streams: list[Stream], shape: tuple[int, ...]
    ) -> tuple[FloatArray, FloatArray, tuple[Bend, ...]]:
        """Return the values and slopes with which the gains of streams of one kind enter a frame,
        of `shape`, and the bends before it."""
        last = self._last.get(streams[0].kind)
        if last is None:
            return np.zeros(shape), np.zeros(shape), ()
        if last.streams == streams:
            return last.gains.end, last.gains.last_slope, last.gains.bends_after(frame.start)
        row = {stream: number for number, stream in enumerate(last.streams)}
        known = [number for number, stream in enumerate(streams) if stream in row]
        rows = [row[streams[number]] for number in known]

        def arranged(values: FloatArray) -> FloatArray:
            result = np.zeros(shape)
            result[known] = values[rows]
            return result

        bends = tuple(
            Bend(bend.time, arranged(bend.amount)) for bend in last.gains.bends_after(frame.start)
        )
        return arranged(last.gains.end), arranged(last.gains.last_slope), bends

    def _delays(
        self, streams: list[Stream], voices: Sequence[Voice | None]
    ) -> tuple[FloatArray, FloatArray]:
        """Return the delays [s] of streams before and at the frame's end, shape (n_streams,
        n_listeners)."""
        last = self._last.get(streams[0].kind)
        if (
            last is not None
            and last.delays is not None
            and last.streams == streams
            and None not in voices
        ):
            return last.delays, np.array(
                [voice.delays for voice in voices if voice is not None], dtype=np.float64
            )
        known: dict[Stream, FloatArray] = {}
        if last is not None and last.delays is not None:
            known = dict(zip(last.streams, last.delays, strict=True))
        after = [
            known[stream] if voice is None else voice.delays
            for stream, voice in zip(streams, voices, strict=True)
        ]
        before = [known.get(stream, delays) for stream, delays in zip(streams, after, strict=True)]
        return np.array(before, dtype=np.float64), np.array(after, dtype=np.float64)


def _weights(streams: Sequence[Stream], voices: Sequence[Voice | None]) -> list[float]:
    """Return the priorities of voices, of streams that fade out the last one."""
    return [
        stream.priority if voice is None else voice.priority
        for stream, voice in zip(streams, voices, strict=True)
    ]
