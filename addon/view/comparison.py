"""The same frame in the four renderings, side by side. No Blender."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...core.arrays import FloatArray
from ...core.propagation import propagate
from ...core.render.frame_result import FrameResult
from ...core.scene.values import Mode, Settings


def compared(result: FrameResult, settings: Settings) -> dict[Mode, FloatArray]:
    """The strongest gain (l,) at each listener, amplitude included, in every mode; contacts and sources are those of the frame."""
    amplitude = np.array([source.amplitude for source in result.sources]).reshape(-1, 1)
    gains = {mode: propagate(result.graph, replace(settings, mode=mode)).gain * amplitude for mode in Mode}
    return {mode: np.asarray(gain.max(axis=0, initial=0.0)) for mode, gain in gains.items()}
