"""From propagated gains to the samples at the listeners."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..scene.values import Listener
from .arrival import are_unfelt
from .frame_result import FrameResult, Sounding
from .mixing import MixingExpression
from .renderer import SAMPLE_RATE, ListenerMix, Renderer
from .voices import Voice

_LIMITER_SECONDS = 0.5
"""Time [s] that a limiter's gain depends on, to a few percent."""


class Mixdown:
    """Mixes and renders frame after frame.

    ``before``: sources, listeners and gains at the start of the last block, None if it was the
    first one.
    """

    def __init__(self, sample_rate: float = SAMPLE_RATE) -> None:
        self.sample_rate = sample_rate
        self.before: Sounding | None = None
        self._renderer: Renderer | None = None
        self._last: Sounding | None = None
        self._skipped = False

    def reset(self) -> None:
        """Drop all active signals."""
        if self._renderer is not None:
            self._renderer.reset()
        self._last, self._skipped = None, False

    def render(self, start: float | None, end: Sounding, heard: bool = True) -> FloatArray | None:
        """The samples (l, n) of a frame.

        Args:
            start: time of the frame before [s], None without one.
            end: time, sources and gains of this frame. Gains move to these over the frame, and from
                these in the next one.
            heard: whether the samples are wanted.

        Returns:
            None without a start or listeners, or if not ``heard``.
        """
        mixes = listener_mixes(end.listeners)
        if self._renderer is None or self._renderer.listeners != mixes:
            self._renderer = Renderer(mixes, self.sample_rate) if mixes else None
            self._last = None
            self._skipped = False
        if self._renderer is None or start is None:
            self.before, self._last, self._skipped = None, end, True
            return None
        self.before, self._last = self._last, end
        if not heard:
            self._skipped = True
            return None
        if self._skipped and self.before is not None:
            self._renderer = primed(
                mixes, self.sample_rate, self.before.time, rendered_voices(self.before)
            )
            self._skipped = False
        return self._renderer.render_frame(start, end.time, rendered_voices(end))


def with_block(result: FrameResult) -> FrameResult:
    """A frame with its samples (l, n). They are rendered now if the trace left them out because
    nothing played them."""
    before = result.before
    if result.block is not None or before is None:
        return result
    renderer = primed(
        listener_mixes(result.listeners), result.sample_rate, before.time, rendered_voices(before)
    )
    block = renderer.render_frame(before.time, result.time, rendered_voices(result))
    return replace(result, block=block)


def primed(
    mixes: tuple[ListenerMix, ...], sample_rate: float, time: float, voices: Sequence[Voice]
) -> Renderer:
    """A renderer that continues from ``time`` [s] with the gains of ``voices``. A limiter has run
    for `_LIMITER_SECONDS` before, so that its gain has settled."""
    renderer = Renderer(mixes, sample_rate)
    start = time - _LIMITER_SECONDS if renderer.latency else time
    renderer.render_frame(start, start, voices)
    if start < time:
        renderer.render_frame(start, time, voices)
    return renderer


def steady(renderer: Renderer, start: float, seconds: float, voices: Sequence[Voice]) -> FloatArray:
    """``seconds`` of samples (l, n) from ``start`` [s] on with constant gains, of a new
    renderer."""
    # A frame of no duration, in which gains jump to their values.
    renderer.render_frame(start, start, voices)
    return renderer.render_frame(start, start + seconds, voices)


def listener_mixes(listeners: Sequence[Listener]) -> tuple[ListenerMix, ...]:
    """The mixes of listeners, for a `Renderer`."""
    return tuple(
        _mix(item.name, item.mixing, item.mixing_expression, item.s_max, item.limiter)
        for item in listeners
    )


@lru_cache(maxsize=1024)
def _mix(name: str, mixing: str, expression: str, s_max: float, limiter: bool) -> ListenerMix:
    method = MixingExpression(expression, s_max) if mixing == "custom" else mixing
    return ListenerMix(name, method, s_max, limiter)  # type: ignore[arg-type]


def source_voices(state: Sounding | FrameResult) -> list[Voice]:
    """One voice per source for a `Renderer`, with its gains at the listeners."""
    return _voices(state, np.ones((len(state.sources), 1)))


def rendered_voices(state: Sounding | FrameResult) -> list[Voice]:
    """`source_voices` without what lies so far under a listener's threshold of feeling that it is
    not rendered."""
    return _voices(state, ~are_unfelt(state.sources, state.listeners, state.propagation))


def _voices(state: Sounding | FrameResult, share: FloatArray | BoolArray) -> list[Voice]:
    """One voice per source, with its gains times the ``share`` (s, l or 1)."""
    propagation = state.propagation
    factor = np.array([item.gain for item in state.listeners]) * share
    gains = (
        propagation.gain * factor
        if propagation.band_gain is None
        else propagation.band_gain * factor[..., None]
    )
    return [
        Voice(
            key=source.name,
            signal=source.emitted,
            gains=own,
            onset=source.onset,
            amplitude=source.amplitude,
            delays=None if propagation.delay is None else propagation.delay[row],
            priority=source.priority,
        )
        for row, (source, own) in enumerate(zip(state.sources, gains, strict=True))
    ]
