"""What a frame that stands alone would feel like if it lasted: so that meters answer to edits while nothing plays. No Blender."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.frame_result import FrameResult
from ...core.rendering import ListenerMix, Renderer, Voice
from ...core.scene import SourceKind
from ...core.signals import DEFAULT_IMPACT, DEFAULT_PERSISTENT

FloatArray = NDArray[np.float64]


def still_samples(result: FrameResult, seconds: float) -> FloatArray:
    """Samples (l, n) of the ``seconds`` up to the frame, with the gains that it has."""
    listeners, propagation = result.listeners, result.propagation
    if not listeners:
        return np.zeros((0, 0))
    mixes = [ListenerMix(name=item.name, method=item.mixing, s_max=item.s_max) for item in listeners]  # type: ignore[arg-type]
    renderer = Renderer(mixes, result.sample_rate)
    hearing = np.array([item.gain for item in listeners])
    gains = propagation.gain if propagation.band_gain is None else propagation.band_gain
    voices = [
        Voice(
            key=source.name,
            signal=source.signal or (DEFAULT_PERSISTENT if source.kind is SourceKind.PERSISTENT else DEFAULT_IMPACT),
            gains=gains[row] * (hearing if gains.ndim == 2 else hearing[:, None]),
            onset=source.onset,
            amplitude=source.amplitude,
            delays=None if propagation.delay is None else propagation.delay[row],
            priority=source.priority,
        )
        for row, source in enumerate(result.sources)
        if source.amplitude > 0
    ]
    start = result.time - seconds
    renderer.render_frame(start - seconds / 2, start, voices)  # sources fade in over the first frame in which they are seen
    return renderer.render_frame(start, result.time, voices)
