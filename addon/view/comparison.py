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


def mode_gains(mode: Mode, traced: Traced, choice: None = None, before: FloatArray | None = None) -> FloatArray:
    """The strongest gain (l,) at each listener in ``mode``, amplitude included; contacts and sources are those of the frame."""
    result, settings = traced.result, traced.settings
    if mode is settings.mode:
        return np.asarray(result.gains.max(axis=0, initial=0.0))
    gain = arriving(result.sources, propagate(result.graph, replace(settings, mode=mode)))
    return np.asarray(gain.max(axis=0, initial=0.0))


_GAINS: dict[Mode, Derived[None, FloatArray]] = {mode: Derived(partial(mode_gains, mode)) for mode in Mode}
"""One computation per mode, so that the worker can trace between them."""


def compared(scene: Scene) -> dict[Mode, Latest[FloatArray]]:
    """The results of `mode_gains` that are complete, without waiting."""
    found = {mode: derived.latest(scene, None) for mode, derived in _GAINS.items()}
    return {mode: latest for mode, latest in found.items() if latest is not None}
