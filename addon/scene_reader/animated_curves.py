"""Animated frequencies as automations over the scene's time, because phases of values
read frame by frame would jump."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
from bpy.types import Object, Scene

from ...core.arrays import FloatArray
from ...core.signals import Automation
from ..blender.arrays import read_array
from ..blender.compatibility import fcurves_of
from ..blender.time import frame_seconds, stretching
from ..properties.signal_kinds import HERTZ

FREQUENCY = "haptics.source.frequency"
_MOST_FRAMES = 100_000
_PARTS = 16
"""Least number of straight lines for a rounded part of a curve."""


class AnimatedCurves:
    """The automations of a scene's sources, recomputed when their keyframes or the scene's frames
    have changed."""

    def __init__(self) -> None:
        # By session id of the object.
        self._known: dict[int, tuple[Any, Automation]] = {}

    def clear(self) -> None:
        """Drop all automations, because curves may have changed."""
        self._known.clear()

    def of_source(self, obj: Object, scene: Scene) -> Automation | None:
        """The frequency of a source over seconds from the scene's first frame, None if no F-curve
        animates it."""
        curve = animating(obj, FREQUENCY)
        if curve is None:
            return None
        key = _description(curve, scene)
        known = self._known.get(obj.session_uid)
        if known is None or known[0] != key:
            known = key, _evaluated(curve, scene)
            self._known[obj.session_uid] = known
        return known[1]


def animating(obj: Object, path: str) -> Any:
    """The F-curve with keys that animates a property of an object; None if there is none."""
    return next(
        (
            c
            for c in fcurves_of(obj)
            if c.data_path == path and not c.mute and len(c.keyframe_points)
        ),
        None,
    )


def corners(curve: Any) -> FloatArray:
    """Frames and values, shape (n, 2), of a piecewise linear F-curve: its keys, and in rounded
    parts one point per frame, at least `_PARTS`; two points at a jump."""
    found: list[tuple[float, float]] = []
    keys = list(curve.keyframe_points)
    most = max(_MOST_FRAMES // len(keys), 1)
    for key, after in pairwise(keys):
        (begin, value), end = key.co, after.co[0]
        found.append((begin, value))
        if key.interpolation == "CONSTANT":
            found.append((end, value))
        elif key.interpolation != "LINEAR":
            inside = np.linspace(begin, end, min(max(math.ceil(end - begin), _PARTS), most) + 1)[
                1:-1
            ]
            found += [(frame, curve.evaluate(frame)) for frame in inside.tolist()]
    return np.array([*found, tuple(keys[-1].co)])


def _description(curve: Any, scene: Scene) -> tuple[Any, ...]:
    """The values that the automation of a curve depends on."""
    points = curve.keyframe_points
    values = [
        read_array(points, name, 2).tobytes() for name in ("co", "handle_left", "handle_right")
    ]
    kinds = [point.interpolation for point in points]
    return (
        values,
        kinds,
        scene.frame_start,
        scene.frame_end,
        scene.render.fps,
        scene.render.fps_base,
        stretching(scene),
    )


def _evaluated(curve: Any, scene: Scene) -> Automation:
    first, last = curve.range()
    stretch = stretching(scene)
    start = min(math.floor(first), math.floor(scene.frame_start / stretch))
    end = max(math.ceil(last), math.ceil(scene.frame_end / stretch))
    frames = range(start, min(end, start + _MOST_FRAMES) + 1)
    lines = np.zeros((0, 2)) if len(curve.modifiers) else corners(curve)
    around = [
        (frame, curve.evaluate(frame))
        for frame in frames
        if not len(lines) or not first <= frame <= last
    ]
    points = np.concatenate([lines, np.array(around).reshape(-1, 2)])
    points = points[np.argsort(points[:, 0], kind="stable")]
    seconds = (points[:, 0] * stretch - scene.frame_start) * frame_seconds(scene)
    return Automation(seconds, np.clip(points[:, 1], *HERTZ))
