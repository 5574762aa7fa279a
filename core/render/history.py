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
    """Consecutive blocks; a jump restarts them. A frame without a block is rendered in the steady
    state for `LEVEL_SECONDS`."""

    def __init__(self) -> None:
        self.sample_rate = 0.0
        self.listeners: tuple[str, ...] = ()
        self._samples = np.zeros((0, 0))
        self._end: int | None = None

    def feed(self, result: FrameResult) -> None:
        """Append the block of the next frame."""
        names = tuple(listener.name for listener in result.listeners)
        block = still_samples(result) if result.block is None else result.block
        alike = names == self.listeners and self.sample_rate == result.sample_rate
        follows = alike and result.block is not None and self._end == result.first_sample
        keep = round(SECONDS * result.sample_rate)
        self._samples = (np.concatenate((self._samples, block), axis=1) if follows else block)[
            :, -keep:
        ]
        self.listeners, self.sample_rate = names, result.sample_rate
        self._end = None if result.block is None else result.first_sample + block.shape[1]

    def take(self, result: FrameResult, samples: FloatArray) -> None:
        """Append a frame with the samples before it: ``samples`` (l, n) up to its end, from a
        track."""
        self.feed(result)
        self._samples = samples[:, -round(SECONDS * result.sample_rate) :]

    def all(self) -> FloatArray:
        """The last second of every listener, (l, n); or all samples if there are fewer."""
        return self._samples


def lasts(result: FrameResult, samples: FloatArray) -> bool:
    """Whether the level of a frame can be taken from the ``samples`` (l, n) up to its end: whether
    they cover the last `LEVEL_SECONDS`, and a frame before that in which sources have faded in.
    Otherwise it is that of `still_samples`."""
    fade_in = 0 if result.block is None else result.block.shape[1]
    return bool(samples.shape[1] >= round(LEVEL_SECONDS * result.sample_rate) + fade_in)


def still_samples(result: FrameResult, seconds: float = LEVEL_SECONDS) -> FloatArray:
    """Samples (l, n) of a single frame if it lasted for ``seconds``: its signals from the start of
    its interval on, with its gains throughout."""
    if not result.listeners:
        return np.zeros((0, 0))
    renderer = Renderer(listener_mixes(result.listeners), result.sample_rate)
    return steady(
        renderer, result.first_sample / result.sample_rate, seconds, source_voices(result)
    )
