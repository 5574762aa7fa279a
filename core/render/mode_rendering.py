"""A traced frame in another of the four modes: contacts, impacts and sources are the same in all of them, so they are found only once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..propagation import propagate
from ..scene.values import Mode, Settings
from ..signals import DEFAULT_IMPACT, Signal
from .frame_result import FrameResult
from .mixdown import Mixdown
from .renderer import SAMPLE_RATE


class ModeRendering:
    """Renders the consecutive frames of a tracer in ``mode``; what it gives is what the tracer would have given in that mode."""

    def __init__(self, mode: Mode, impact_signal: Signal = DEFAULT_IMPACT, sample_rate: float = SAMPLE_RATE) -> None:
        self.mode = mode
        self._mixdown = Mixdown(impact_signal, sample_rate)
        self._time: float | None = None

    def of(self, result: FrameResult, settings: Settings) -> FrameResult:
        """The frame in this mode, the rest of ``settings`` as they are. A frame that the tracer began afresh begins afresh here."""
        if result.block is None:
            self._mixdown.reset()
            self._time = None
        propagation = propagate(result.graph, replace(settings, mode=self.mode), sounding_only=True)
        block = self._mixdown.render(self._time, result.time, result.sources, result.listeners, propagation)
        self._time = result.time
        return replace(
            result,
            propagation=propagation,
            gains=propagation.gain * np.array([source.amplitude for source in result.sources]).reshape(-1, 1),
            block=block,
            warnings=propagation.warnings,
        )
