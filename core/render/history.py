"""The last second of samples at every listener of a scene."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from .frame_result import FrameResult
from .levels import LEVEL_SECONDS
from .mixdown import listener_mixes, source_voices, steady
from .renderer import Renderer

SECONDS = 1.0


class History:
    """Consecutive blocks of ``count`` samples in total; a jump restarts them. A frame without a
    block is rendered in the steady state for `LEVEL_SECONDS`."""

    def __init__(self) -> None:
        self.sample_rate: float = 0.0
        self.listeners: tuple[str, ...] = ()
        self.count: int = 0
        self._blocks = [np.zeros((0, 0))]
        self._end: int | None = None

    def feed(self, result: FrameResult) -> None:
        """Append the block of the next frame."""
        names = tuple(listener.name for listener in result.listeners)
        block = still_samples(result) if result.block is None else result.block
        alike = names == self.listeners and self.sample_rate == result.sample_rate
        follows = alike and result.block is not None and self._end == result.first_sample
        if not follows:
            self._blocks, self.count = [], 0
        self._blocks.append(block)
        self.count += block.shape[1]
        while self.count - self._blocks[0].shape[1] >= SECONDS * result.sample_rate:
            self.count -= self._blocks.pop(0).shape[1]
        self.listeners, self.sample_rate = names, result.sample_rate
        self._end = None if result.block is None else result.first_sample + block.shape[1]

    def take(self, result: FrameResult, samples: FloatArray) -> None:
        """Append a frame with the samples before it: ``samples`` (l, n) up to its end, from a
        track."""
        self.feed(result)
        self._blocks, self.count = [samples], samples.shape[1]

    def all(self, seconds: float = SECONDS) -> FloatArray:
        """The last ``seconds``, at most one, of every listener, (l, n); or all samples if there are
        fewer."""
        count = max(round(seconds * self.sample_rate), 1)
        first = len(self._blocks) - 1
        held = self._blocks[-1].shape[1]
        while first > 0 and held < count:
            first -= 1
            held += self._blocks[first].shape[1]
        return np.concatenate(self._blocks[first:], axis=1)[:, -count:]


def lasts(result: FrameResult, count: int) -> bool:
    """Whether the level of a frame can be taken from the ``count`` samples up to its end: whether
    they cover the last `LEVEL_SECONDS`, and a frame before that in which sources have faded in.
    Otherwise it is that of `still_samples`."""
    fade_in = 0 if result.block is None else result.block.shape[1]
    return bool(count >= round(LEVEL_SECONDS * result.sample_rate) + fade_in)


def still_samples(result: FrameResult, seconds: float = LEVEL_SECONDS) -> FloatArray:
    """Samples (l, n) of a single frame if it lasted for ``seconds``: its signals from the start of
    its interval on, with its gains throughout."""
    if not result.listeners:
        return np.zeros((0, 0))
    renderer = Renderer(listener_mixes(result.listeners), result.sample_rate)
    return steady(
        renderer, result.first_sample / result.sample_rate, seconds, source_voices(result)
    )
