"""What live outputs play: blocks that follow the picture while the timeline runs, short grains where it is scrubbed.

Each block holds the samples of the frame that has just become visible, whatever was dropped, repeated or jumped over before it, so that
touch never shifts against the picture. Frame by frame it is what a bake gives, sample for sample.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import partial

import numpy as np

from ..arrays import FloatArray
from .frame_result import FrameResult
from .mixdown import listener_mixes, source_voices
from .renderer import ListenerMix, Renderer, sample_index
from .voices import Voice

GRAIN = 0.100
"""Seconds that a frame is felt for when it is scrubbed to."""
_GRAIN_RISE, _GRAIN_FALL = 0.005, 0.040
# So that a device that is told levels, looking at 40 ms of signal, comes to zero within the grain's own block.
_GRAIN_SILENCE = 0.060
# A recorded block that is not the continuation of the last one begins at its last value, and leaves it within so many seconds.
_SEAM = 0.008
# Frames that are dropped are rendered and left out; what jumps further is another place of the timeline.
_LONGEST_STEP = 1.0


class Playback:
    """The stream of blocks of one scene while it plays."""

    def __init__(self) -> None:
        self._renderer: Renderer | None = None
        self._time: float | None = None
        self._last = np.zeros((0, 1))
        self._next = -1
        self._heard: float | None = None  # when the last result was that was played
        self._late: dict[Hashable, float] = {}  # onsets that were moved, by voice

    def start(self, time: float) -> None:
        """Begin at ``time`` [s], from silence."""
        self._renderer, self._time = None, time
        self._last, self._next = np.zeros((0, 1)), -1
        self._heard = None
        self._late.clear()

    def recorded(self, result: FrameResult) -> FloatArray:
        """The samples of a frame that was read from a track, (listeners, n), joined to those before where frames lie between."""
        if result.block is None or result.time == self._time:
            return np.zeros((len(result.listeners), 0))
        block = result.block.copy()
        if result.first_sample != self._next and block.shape[1]:
            last = self._last if self._last.shape[0] == block.shape[0] else np.zeros((block.shape[0], 1))
            seam = block[:, : round(_SEAM * result.sample_rate)]
            seam += (last - seam) * (1.0 - (np.arange(seam.shape[1]) + 1.0) / seam.shape[1])
        self._renderer, self._time = None, result.time
        self._last, self._next = block[:, -1:], result.first_sample + block.shape[1]
        return block

    def block(self, result: FrameResult, frame_seconds: float) -> FloatArray:
        """The samples of the frame that ends at ``result``, (listeners, n): ``frame_seconds`` long, or nothing where it was played already.

        At a jump (a loop, a step back, a long gap) what sounded fades out while what sounds there fades in.
        """
        mixes = listener_mixes(result.listeners)
        if self._time == result.time and self._renderer is not None:
            return np.zeros((len(mixes), 0))
        block = self._continued(mixes, result, result.time, frame_seconds)
        return self._elsewhere(mixes, result, frame_seconds) if block is None else block

    def ahead(self, latest: FrameResult, time: float, frame_seconds: float) -> FloatArray | None:
        """The samples of the frame that ends at ``time`` [s], which is still being traced, with what the ``latest`` traced frame says; None
        where that is no continuation. What has begun in a frame that comes late begins with the next block."""
        mixes = listener_mixes(latest.listeners)
        if self._time is None or self._renderer is None or self._renderer.listeners != mixes:
            return None
        return self._continued(mixes, latest, time, frame_seconds)

    def following(self, result: FrameResult, seconds: float) -> Callable[[], FloatArray]:
        """A function that renders the ``seconds`` after the last block, (listeners, n), if the scene stayed as ``result`` shows it.

        It may be called later, by any thread. What it gives does not count as played: the next block is what it would be without it.
        """
        if self._time is None or self._renderer is None:
            return partial(np.zeros, (len(result.listeners), 0))
        voices = self._moved(source_voices(result.sources, result.listeners, result.propagation))
        return partial(self._renderer.fork().render_frame, self._time, self._time + seconds, voices)

    def _continued(self, mixes: tuple[ListenerMix, ...], result: FrameResult, time: float, frame_seconds: float) -> FloatArray | None:
        """The samples up to ``time`` where they follow what was played so far, else None."""
        before = self._renderer if self._renderer is not None and self._renderer.listeners == mixes else None
        begun = self._time
        if begun is None or not 0.0 < time - begun <= max(_LONGEST_STEP, 1.5 * frame_seconds) or self._renderer not in (None, before):
            return None
        renderer = before or Renderer(mixes, result.sample_rate)
        samples = renderer.render_frame(begun, time, self._voices(result, begun))
        start = begun if time - begun < 1.5 * frame_seconds else time - frame_seconds
        self._renderer, self._time = renderer, time
        return samples[:, samples.shape[1] - _count(start, time, result.sample_rate) :]

    def _elsewhere(self, mixes: tuple[ListenerMix, ...], result: FrameResult, frame_seconds: float) -> FloatArray:
        """The samples up to ``result`` at another place of the timeline."""
        before, begun = self._renderer, self._time
        self._late.clear()
        renderer = Renderer(mixes, result.sample_rate)
        block = renderer.render_frame(result.time - frame_seconds, result.time, self._voices(result, result.time - frame_seconds))
        if before is not None and before.listeners == mixes and begun is not None:
            ending = before.render_frame(begun, begun + frame_seconds, ())[:, : block.shape[1]]
            block[:, : ending.shape[1]] += ending
            ceilings = np.array([mix.s_max for mix in mixes])[:, None]
            block = np.clip(block, -ceilings, ceilings)
        self._renderer, self._time = renderer, result.time
        return block

    def _voices(self, result: FrameResult, begun: float) -> list[Voice]:
        """What is played of a result in a block that begins at ``begun``: what began after the last result, but before this block, begins
        with it."""
        voices = source_voices(result.sources, result.listeners, result.propagation)
        heard, self._heard = self._heard, result.time
        if heard is not None and heard < begun:
            self._late.update({voice.key: begun for voice in voices if heard <= voice.onset < begun and voice.key not in self._late})
        if not self._late:
            return voices
        self._late = {voice.key: self._late[voice.key] for voice in voices if voice.key in self._late}
        return self._moved(voices)

    def _moved(self, voices: list[Voice]) -> list[Voice]:
        """The voices, each from the onset that it is played from."""
        return [voice._replace(onset=self._late.get(voice.key, voice.onset)) for voice in voices]


def grain(result: FrameResult, frame_seconds: float) -> FloatArray:
    """A short touch of a frame, (listeners, n), that begins and ends in silence: its last frame and what goes on from there."""
    start = result.time - frame_seconds
    renderer = Renderer(listener_mixes(result.listeners), result.sample_rate)
    voices = source_voices(result.sources, result.listeners, result.propagation)
    renderer.render_frame(start, start, voices)
    return _shaped(renderer.render_frame(start, start + GRAIN, voices), result.sample_rate)


def recorded_grain(result: FrameResult) -> FloatArray:
    """A short touch of a frame that was read from a track."""
    block = np.zeros((len(result.listeners), 0)) if result.block is None else result.block
    return _shaped(block[:, : round(GRAIN * result.sample_rate)], result.sample_rate)


def _shaped(samples: FloatArray, sample_rate: float) -> FloatArray:
    """Samples that begin and end in silence."""
    if not samples.shape[1]:
        return samples
    seconds = (np.arange(samples.shape[1]) + 0.5) / sample_rate
    rise, fall = np.clip(seconds / _GRAIN_RISE, 0.0, 1.0), np.clip((seconds[-1] - seconds) / _GRAIN_FALL, 0.0, 1.0)
    silence = np.zeros((samples.shape[0], round(_GRAIN_SILENCE * sample_rate)))
    return np.concatenate([samples * np.sin(0.5 * np.pi * np.minimum(rise, fall)) ** 2, silence], axis=1)


def _count(start: float, end: float, sample_rate: float) -> int:
    return sample_index(end, sample_rate) - sample_index(start, sample_rate)
