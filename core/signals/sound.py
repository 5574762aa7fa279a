"""Analysis of sounds: level, pitch and onsets over time.

The level is that of the analytic signal (S. L. Marple, "Computing the discrete-time analytic signal
via FFT", IEEE Trans. Signal Processing 47, 1999), from `LOWEST` hertz on. Generators compute block
by block, so that their caller can show progress and cancel.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..frozen import frozen
from . import onsets, pitch
from .automation import Automation, values_of

RATE = 16_000
"""Sample rate of the analysis [Hz]."""
RATES = (1000.0, 2e6)
"""Lowest and highest sample rate of recordings [Hz]."""
HOP = 0.005
"""Seconds from one level to the next."""
LONGEST = 1800.0
"""Longest sound [s]; it takes 115 MB."""
LOWEST = 10.0
"""Lowest frequency that contributes to the level [Hz]."""

_BLOCK = 8 * RATE
_MARGIN = RATE // 4
_FINE = RATE // 1000
_HOP = RATE // 200

Samples = NDArray[np.float32]
Value = TypeVar("Value")
Steps = Generator[None, None, Value]
"""Yields after each block, and returns the value."""


class SoundSamples(Protocol):
    """The interface of a decoded sound: ``count`` samples per channel at ``rate`` hertz."""

    rate: float
    count: int

    def read(self, first: int, last: int) -> FloatArray:
        """Return the samples from index ``first`` to before ``last``, shape (last - first,
        channels), full scale being 1."""


@frozen
class Clip:
    """A part of a recording, placed in a sound.

    start: its beginning in the sound [s], below 0 if the sound begins within it; skip: its
    beginning in the recording at playback speed [s]; seconds: its largest duration. speed: playback
    speed. volume: a factor, constant or over the sound's time.
    """

    recording: SoundSamples
    start: float = 0.0
    skip: float = 0.0
    seconds: float = math.inf
    speed: float = 1.0
    volume: float | Automation = 1.0

    @property
    def rate(self) -> float:
        """Sample rate at playback speed [Hz]."""
        return self.recording.rate * self.speed

    @property
    def samples(self) -> tuple[int, int]:
        """Index of the recording's first audible sample, and of the one after the last."""
        first = round((self.skip + max(-self.start, 0.0)) * self.rate)
        last = min(self.recording.count, (self.skip + self.seconds) * self.rate)
        return first, max(round(last), first)

    @property
    def end(self) -> float:
        """Its end in the sound [s]."""
        first, last = self.samples
        return max(self.start, 0.0) + (last - first) / self.rate


@frozen(eq=False)
class Heard:
    """Result of the analysis of a sound of ``seconds``.

    levels: amplitude every `HOP` seconds from 0 on, averaged over 10 ms; that of a sine of full
    scale is 1. pitches: hertz at the same times, 0 without pitch. onsets: beginnings of events [s].
    strengths: the largest level in the 30 ms after each.
    """

    seconds: float
    levels: FloatArray
    pitches: FloatArray
    onsets: FloatArray
    strengths: FloatArray


def outcome(steps: Steps[Value]) -> Value:
    """Run the generator to its end and return its value."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            value: Value = end.value
            return value


def mixed(clips: tuple[Clip, ...]) -> Steps[Samples]:
    """The sum of clips, the channels of each averaged, shape (n,), `RATE` a second.

    Raises ValueError if it is longer than `LONGEST` or silent, has samples that are not finite, or
    a sample rate outside `RATES`.
    """
    import soxr

    # Beyond these, the resampler may crash.
    if not all(RATES[0] <= clip.rate <= RATES[1] for clip in clips):
        raise ValueError("the sound has too many or too few samples a second")
    length = max((clip.end for clip in clips), default=0.0)
    if length > LONGEST:
        raise ValueError("the sound is longer than 30 minutes")
    result = np.zeros(math.ceil(length * RATE), dtype=np.float32)
    for clip in clips:
        stream = soxr.ResampleStream(clip.rate, RATE, 1, dtype="float64")
        place = round(max(clip.start, 0.0) * RATE)
        size = max(round(_BLOCK * clip.rate / RATE), 1)
        first, last = clip.samples
        for begin in range(first, last, size):
            samples = clip.recording.read(begin, min(begin + size, last)).mean(axis=1)
            if not np.isfinite(samples).all():
                raise ValueError("the sound has samples that are not finite")
            ready = stream.resample_chunk(samples, last=begin + size >= last)[
                : max(len(result) - place, 0)
            ]
            times = np.arange(place, place + len(ready)) / RATE
            result[place : place + len(ready)] += ready * values_of(clip.volume, times)
            place += len(ready)
            yield
    if not result.any():
        raise ValueError("the sound is silent")
    return result


def block_count(seconds: float) -> int:
    """Number of times that `heard` yields."""
    return math.ceil(math.ceil(seconds * RATE) / _BLOCK)


def heard(samples: Samples) -> Steps[Heard]:
    """Analyse a sound, shape (n,), at `RATE` hertz."""
    count = len(samples)
    power = [np.zeros(0)]
    fluxes = [np.zeros(0)]
    pitched = [np.zeros(0)]
    for begin in range(0, count, _BLOCK):
        end = min(begin + _BLOCK, -(-count // _HOP) * _HOP)
        power.append(
            _power(_read(samples, begin - _MARGIN, end + _MARGIN))[_MARGIN:][: end - begin]
            .reshape(-1, _FINE)
            .mean(axis=1)
        )
        reach = onsets.FRAME // 2
        around = _read(samples, begin - reach - onsets.LAG * _HOP, end - _HOP + reach)
        fluxes.append(onsets.flux(onsets.band_levels(_frames(around, onsets.FRAME))))
        around = _read(samples, begin - pitch.FRAME // 2, end - _HOP + pitch.FRAME // 2)
        pitched.append(
            np.repeat(pitch.pitches(_frames(around, pitch.FRAME)[::2], RATE), 2)[
                : (end - begin) // _HOP
            ]
        )
        yield
    fine = np.concatenate(power)
    sums = np.cumsum(np.pad(fine, (1 + _HOP // _FINE, _HOP // _FINE)))
    width = 2 * _HOP // _FINE
    levels = np.sqrt(
        np.maximum(sums[width :: width // 2] - sums[: -width : width // 2], 0.0) / width
    )
    times = onsets.onsets(np.concatenate(fluxes), HOP, fine)
    after = np.lib.stride_tricks.sliding_window_view(np.pad(levels, (0, 7)), 7).max(axis=1)
    strengths = after[np.minimum(np.rint(times / HOP).astype(np.intp), len(levels) - 1)]
    return Heard(count / RATE, levels, np.append(np.concatenate(pitched), 0.0), times, strengths)


def _read(samples: Samples, first: int, last: int) -> FloatArray:
    """Samples from ``first`` to before ``last``, zeros beyond the ends."""
    inside = samples[max(first, 0) : max(last, 0)].astype(np.float64)
    return np.pad(inside, (max(-first, 0), last - max(first, 0) - len(inside)))


def _frames(samples: FloatArray, length: int) -> FloatArray:
    return np.lib.stride_tricks.sliding_window_view(samples, length)[::_HOP]


def _power(samples: FloatArray) -> FloatArray:
    """The squared envelope of samples, by their analytic signal; the first and last `_MARGIN` of
    them are faded in place."""
    fade = np.hanning(2 * _MARGIN + 1)[:_MARGIN]
    samples[:_MARGIN] *= fade
    samples[-_MARGIN:] *= fade[::-1]
    count = len(samples)
    spectrum = np.zeros(count, dtype=np.complex128)
    half = np.fft.rfft(samples)[: (count + 1) // 2]
    half[: math.ceil(LOWEST * count / RATE)] = 0.0
    spectrum[: len(half)] = 2.0 * half
    analytic = np.fft.ifft(spectrum)
    return analytic.real**2 + analytic.imag**2
