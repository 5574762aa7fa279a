"""Animated frequencies as automations over the scene's time; read frame by frame, their phase would jump at every frame."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from bpy.types import Object, Scene

from ...core.signals import Automation
from ..blender.compatibility import fcurves_of

PATH = "haptics.source.frequency"
_LOWEST, _HIGHEST = 0.1, 1000.0  # hertz, as the property allows
_MOST_FRAMES = 100_000


class AnimatedFrequencies:
    """The automations of a scene's sources, recomputed when their keyframes or the scene's frames have changed."""

    def __init__(self) -> None:
        self._known: dict[int, tuple[Any, Automation]] = {}  # by session id of the object

    def clear(self) -> None:
        """Drop all automations, as curves may have changed."""
        self._known.clear()

    def automation(self, obj: Object, scene: Scene) -> Automation | None:
        """The frequency of a source in hertz over seconds from the scene's first frame, None where no F-curve animates it."""
        curve = next((c for c in fcurves_of(obj) if c.data_path == PATH and not c.mute), None)
        if curve is None or not len(curve.keyframe_points):
            return None
        key = _description(curve, scene)
        known = self._known.get(obj.session_uid)
        if known is None or known[0] != key:
            known = key, _evaluated(curve, scene)
            self._known[obj.session_uid] = known
        return known[1]


def _description(curve: Any, scene: Scene) -> tuple[Any, ...]:
    """The values that the automation of a curve depends on."""
    points = curve.keyframe_points
    values = np.empty((3, 2 * len(points)), dtype=np.float32)
    for row, name in zip(values, ("co", "handle_left", "handle_right"), strict=True):
        points.foreach_get(name, row)
    return values.tobytes(), scene.frame_start, scene.frame_end, scene.render.fps, scene.render.fps_base


def _evaluated(curve: Any, scene: Scene) -> Automation:
    first, last = curve.range()
    start = min(math.floor(first), scene.frame_start)
    frames = range(start, min(max(math.ceil(last), scene.frame_end), start + _MOST_FRAMES) + 1)
    seconds = (np.array(frames) - scene.frame_start) * (scene.render.fps_base / scene.render.fps)
    return Automation(seconds, np.clip([curve.evaluate(frame) for frame in frames], _LOWEST, _HIGHEST))
