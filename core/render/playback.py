"""Playback for live outputs: blocks that follow the picture while the timeline runs, short grains
where it is scrubbed.

Each block has the samples of the frame that has just become visible, even after dropped, repeated
or skipped frames, so that touch never drifts from the picture. For consecutive frames it equals the
bake sample by sample.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from functools import partial
from itertools import pairwise

import numpy as np

from ..arrays import FloatArray
from ..frozen import frozen
from .frame_result import FrameResult
from .mixdown import listener_mixes, primed, rendered_voices, steady
from .renderer import ListenerMix, Renderer, sample_index
from .voices import Voice

GRAIN = 0.100
"""Duration of the grain during scrubbing [s]."""
_GRAIN_RISE, _GRAIN_FALL = 0.005, 0.040
# Allows a device with a window of 40 ms to fall to zero within the grain's block.
_GRAIN_SILENCE = 0.060
# A recorded block that does not continue the last one fades from its last value within this time
# [s].
_SEAM = 0.008
# Dropped frames are rendered and left out up to this gap [s]; larger ones are jumps.
_LONGEST_STEP = 1.0


class Playback:
    """The stream of blocks of one scene while it plays."""

    def __init__(self) -> None:
        self._renderer: Renderer | None = None  # None where the last block was the result's own
        self._in_step = False  # whether its state is that of the tracer's own renderer
        self._shown: FrameResult | None = None  # the last result that was played
        self._time: float | None = None  # the end of what was played
        self._last = np.zeros((0, 1))
        self._next = -1
        self._late: dict[Hashable, float] = {}  # onsets that were moved, by voice
        self._correctable: _Correctable | None = None

    def start(self, time: float) -> None:
        """Begin at ``time`` [s], from silence."""
        self._renderer, self._time, self._shown = None, time, None
        self._last = np.zeros((0, 1))
        self._next = -1
        self._late.clear()
        self._correctable = None

    def recorded(self, result: FrameResult) -> FloatArray:
        """The samples of a frame that was read from a track, (listeners, n), cross-faded after
        skipped frames."""
        if result.block is None or result.time == self._time:
            return np.zeros((len(result.listeners), 0))
        block = result.block.copy()
        if result.first_sample != self._next and block.shape[1]:
            last = (
                self._last
                if self._last.shape[0] == block.shape[0]
                else np.zeros((block.shape[0], 1))
            )
            seam = block[:, : round(_SEAM * result.sample_rate)]
            seam += (last - seam) * (1.0 - (np.arange(seam.shape[1]) + 1.0) / seam.shape[1])
        self._renderer, self._time, self._shown, self._correctable = None, result.time, None, None
        self._last = block[:, -1:]
        self._next = result.first_sample + block.shape[1]
        return block

    def block(self, result: FrameResult, frame_seconds: float) -> FloatArray:
        """The samples of the frame that ends at ``result``, (listeners, n): ``frame_seconds`` long,
        or empty if it was played already.

        At a jump (a loop, a step back, a long gap) the old signal fades out while the new one fades
        in.
        """
        self._correctable = None
        mixes = listener_mixes(result.listeners)
        if self._time == result.time and self._shown is not None:
            return np.zeros((len(mixes), 0))
        if result.block is not None and self._is_next(result, mixes):
            self._renderer, self._time, self._shown = None, result.time, result
            return result.block
        block = self._continued(mixes, result, result.time, frame_seconds)
        return self._after_jump(mixes, result, frame_seconds) if block is None else block

    def ahead(self, latest: FrameResult, time: float, frame_seconds: float) -> FloatArray | None:
        """The samples of the frame that ends at ``time`` [s], whose trace is late, with the gains
        of the ``latest`` traced frame; None if it does not continue the last block. Sources that
        begin in such a frame are heard from the next block or `correction` on."""
        samples = self._continued(listener_mixes(latest.listeners), latest, time, frame_seconds)
        if samples is not None:
            self._correctable = _Correctable(
                latest, time - samples.shape[1] / latest.sample_rate, time
            )
        return samples

    def correction(self, result: FrameResult, elapsed: float) -> FloatArray | None:
        """The rest (listeners, n) of a block that was played `ahead` of its trace, now with the
        gains of its ``result``; None if there is nothing to correct.

        Args:
            result: the traced frame.
            elapsed: seconds of the block that were played.
        """
        played = self._correctable
        mixes = listener_mixes(result.listeners)
        if played is None or listener_mixes(played.result.listeners) != mixes:
            return None
        now = played.start + elapsed
        voices = rendered_voices(result)
        if now >= played.end or _are_alike(voices, rendered_voices(played.result)):
            return None
        self._renderer = _primed(played.result, now, self._late)
        samples = self._renderer.render_frame(now, played.end, self._voices(result, now))
        self._shown = result
        self._correctable = _Correctable(result, played.start, played.end)
        return samples

    def following(self, result: FrameResult, seconds: float) -> Callable[[], FloatArray]:
        """A function that renders the ``seconds`` after the last block, (listeners, n), with the
        sources and gains of ``result``.

        It may be called later, by any thread, and does not affect the next block.
        """
        if self._time is None:
            return partial(np.zeros, (len(result.listeners), 0))
        time = self._time
        late = dict(self._late)

        def render() -> FloatArray:
            voices = _with_late_onsets(rendered_voices(result), late)
            return _primed(result, time, late).render_frame(time, time + seconds, voices)

        return render

    def _is_next(self, result: FrameResult, mixes: tuple[ListenerMix, ...]) -> bool:
        """Whether the block of a result continues the last one: the whole frame before it was
        played, without late onsets."""
        if (
            self._shown is None
            or self._shown.block is None
            or self._shown.time != self._time
            or self._late
        ):
            return False
        if self._renderer is not None and not self._in_step:
            return False
        follows = (
            result.first_sample == sample_index(self._time, result.sample_rate)
            and result.sample_rate == self._shown.sample_rate
        )
        return follows and listener_mixes(self._shown.listeners) == mixes

    def _current(self, mixes: tuple[ListenerMix, ...]) -> Renderer | None:
        """The renderer that goes on from the last block; None before the first one, and for other
        listeners."""
        if self._renderer is None and self._shown is not None and self._time is not None:
            self._renderer = _primed(self._shown, self._time, self._late)
        return (
            self._renderer
            if self._renderer is not None and self._renderer.listeners == mixes
            else None
        )

    def _continued(
        self, mixes: tuple[ListenerMix, ...], result: FrameResult, time: float, frame_seconds: float
    ) -> FloatArray | None:
        """The samples up to ``time`` if they continue the last block, else None."""
        before = self._current(mixes)
        begun = self._time
        if (
            begun is None
            or not 0.0 < time - begun <= max(_LONGEST_STEP, 1.5 * frame_seconds)
            or self._renderer not in (None, before)
        ):
            return None
        rate = result.sample_rate
        renderer = before or Renderer(mixes, rate)
        samples = renderer.render_frame(begun, time, self._voices(result, begun))
        start = begun if time - begun < 1.5 * frame_seconds else time - frame_seconds
        played = self._shown is not None and self._shown.time == begun
        self._in_step = (
            played
            and result.time == time
            and result.before is not None
            and result.before.time == begun
        )
        self._renderer, self._time, self._shown = renderer, time, result
        return samples[:, samples.shape[1] - sample_index(time, rate) + sample_index(start, rate) :]

    def _after_jump(
        self, mixes: tuple[ListenerMix, ...], result: FrameResult, frame_seconds: float
    ) -> FloatArray:
        """The samples up to ``result`` after a jump on the timeline, during which what was played
        before fades out."""
        before = self._current(mixes)
        begun = self._time
        self._late.clear()
        renderer = Renderer(mixes, result.sample_rate)
        block = renderer.render_frame(
            result.time - frame_seconds,
            result.time,
            self._voices(result, result.time - frame_seconds),
        )
        if before is not None and begun is not None:
            ending = before.render_frame(begun, begun + frame_seconds, ())[:, : block.shape[1]]
            block[:, : ending.shape[1]] += ending
            ceilings = np.array([mix.s_max for mix in mixes])[:, None]
            block = np.clip(block, -ceilings, ceilings)
        self._renderer = renderer
        self._time = result.time
        self._shown = result
        self._in_step = False
        return block

    def _voices(self, result: FrameResult, begun: float) -> list[Voice]:
        """The voices of a result in a block that begins at ``begun`` [s]. Voices whose onset lies
        before that, but after the last result, were not known in time: they begin with the
            block."""
        voices = rendered_voices(result)
        shown = self._shown
        if shown is not None and shown.time < begun:
            known = {voice.key for voice in rendered_voices(shown)} | self._late.keys()
            self._late.update(
                {
                    voice.key: begun
                    for voice in voices
                    if shown.time <= voice.onset < begun and voice.key not in known
                }
            )
        if self._late:
            self._late = {
                voice.key: self._late[voice.key] for voice in voices if voice.key in self._late
            }
        return _with_late_onsets(voices, self._late)


@frozen
class _Correctable:
    """A block from ``start`` to ``end`` [s] that was played before its frame was traced, with the
    gains of ``result``."""

    result: FrameResult
    start: float
    end: float


def _with_late_onsets(voices: list[Voice], late: Mapping[Hashable, float]) -> list[Voice]:
    """The ``voices``, with the onsets of those that began ``late``, by key [s]."""
    return (
        [voice._replace(onset=late[voice.key]) if voice.key in late else voice for voice in voices]
        if late
        else voices
    )


def _are_alike(voices: list[Voice], others: list[Voice]) -> bool:
    """Whether voices have the same signals and gains."""
    return len(voices) == len(others) and all(
        (one.key, one.onset, one.amplitude, one.priority)
        == (other.key, other.onset, other.amplitude, other.priority)
        and np.array_equal(one.gains, other.gains)
        and (one.delays is None) == (other.delays is None)
        and (one.delays is None or other.delays is None or np.array_equal(one.delays, other.delays))
        and (one.signal is other.signal or one.signal == other.signal)
        for one, other in zip(voices, others, strict=True)
    )


def _primed(shown: FrameResult, time: float, late: Mapping[Hashable, float]) -> Renderer:
    """A renderer that continues from ``time`` [s] with the gains of ``shown`` and a settled
    limiter; ``late``: onsets of voices that began late, by key [s]."""
    voices = _with_late_onsets(rendered_voices(shown), late)
    times = [time]
    earlier = voices
    if shown.block is not None and shown.time <= time:  # its lines of gains may bend here
        before = shown.before
        times = [
            shown.first_sample / shown.sample_rate if before is None else before.time,
            shown.time,
            time,
        ]
        earlier = [] if before is None else rendered_voices(before)
    renderer = primed(listener_mixes(shown.listeners), shown.sample_rate, times[0], earlier)
    for begun, end in pairwise(times):
        if begun < end:
            renderer.render_frame(begun, end, voices)
    return renderer


def grain(result: FrameResult, frame_seconds: float) -> FloatArray:
    """A short touch of a frame while the timeline is scrubbed, (listeners, n): `GRAIN` seconds from
    the start of its interval, faded in and out."""
    renderer = Renderer(listener_mixes(result.listeners), result.sample_rate)
    return _shaped(
        steady(renderer, result.time - frame_seconds, GRAIN, rendered_voices(result)),
        result.sample_rate,
    )


def recorded_grain(result: FrameResult) -> FloatArray:
    """A `grain` of a frame that was read from a track."""
    block = np.zeros((len(result.listeners), 0)) if result.block is None else result.block
    return _shaped(block[:, : round(GRAIN * result.sample_rate)], result.sample_rate)


def _shaped(samples: FloatArray, sample_rate: float) -> FloatArray:
    """``samples`` (l, n) with a fade-in, a fade-out and a silence after it."""
    if not samples.shape[1]:
        return samples
    seconds = (np.arange(samples.shape[1]) + 0.5) / sample_rate
    rise = np.clip(seconds / _GRAIN_RISE, 0.0, 1.0)
    fall = np.clip((seconds[-1] - seconds) / _GRAIN_FALL, 0.0, 1.0)
    silence = np.zeros((samples.shape[0], round(_GRAIN_SILENCE * sample_rate)))
    return np.concatenate(
        [samples * np.sin(0.5 * np.pi * np.minimum(rise, fall)) ** 2, silence], axis=1
    )
