"""What a frame that stands alone would feel like if it lasted: so that meters answer to edits while nothing plays. No Blender."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from .frame_result import FrameResult
from .mixdown import listener_mixes, source_voices
from .renderer import Renderer


def still_samples(result: FrameResult, seconds: float) -> FloatArray:
    """Samples (l, n) of the ``seconds`` up to the frame, with the gains that it has."""
    if not result.listeners:
        return np.zeros((0, 0))
    renderer = Renderer(listener_mixes(result.listeners), result.sample_rate)
    voices = source_voices(result.sources, result.listeners, result.propagation)
    start = result.time - seconds
    renderer.render_frame(start - seconds / 2, start, voices)  # sources fade in over the first frame in which they are seen
    return renderer.render_frame(start, result.time, voices)
