"""The same frame in the four modes, side by side."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from bpy.types import Scene

from ...core.arrays import FloatArray
from ...core.propagation import propagate
from ...core.render.arrival import arriving
from ...core.scene.values import Mode
from ..session.derived import Derived, Latest
from ..session.sessions import Traced


def mode_amplitudes(
    mode: Mode, traced: Traced, choice: None = None, before: FloatArray | None = None
) -> FloatArray:
    """The largest amplitude (l,) that arrives at each listener in ``mode``; contacts and sources
    are those of the frame."""
    result, settings = traced.result, traced.settings
    if mode is settings.mode:
        return np.asarray(result.amplitudes.max(axis=0, initial=0.0))
    amplitudes = arriving(result.sources, propagate(result.graph, replace(settings, mode=mode)))
    return np.asarray(amplitudes.max(axis=0, initial=0.0))


_AMPLITUDES: dict[Mode, Derived[None, FloatArray]] = {
    mode: Derived(partial(mode_amplitudes, mode)) for mode in Mode
}
"""One computation per mode, so that the worker can trace between them."""


def compared(scene: Scene) -> dict[Mode, Latest[FloatArray]]:
    """The results of `mode_amplitudes` that are complete, without waiting."""
    found = {mode: derived.latest(scene, None) for mode, derived in _AMPLITUDES.items()}
    return {mode: latest for mode, latest in found.items() if latest is not None}
