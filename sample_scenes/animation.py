"""Animation curves written key by key, the same whatever the user's preferences say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import bpy
from bpy.types import FCurve

Value = float | Sequence[float]

CONSTANT, LINEAR, BEZIER = "CONSTANT", "LINEAR", "BEZIER"


def animate(owner: Any, path: str, keys: Mapping[Any, Value], interpolation: str = LINEAR) -> None:
    """Keys of a property (``location``, ``energy``) by frame: numbers, or one tuple per frame for a
    property of several channels."""
    frames = sorted(keys)
    channels = [
        [value] if isinstance(value, int | float) else list(value)
        for value in (keys[frame] for frame in frames)
    ]
    for index in range(len(channels[0])):
        curve = _curve(owner, path, index)
        curve.keyframe_points.add(len(frames))
        pairs = zip(frames, (values[index] for values in channels), strict=True)
        curve.keyframe_points.foreach_set("co", [number for pair in pairs for number in pair])
        for point in curve.keyframe_points:
            point.interpolation = interpolation
            point.handle_left_type = point.handle_right_type = "AUTO_CLAMPED"
        curve.update()


def _curve(owner: Any, path: str, index: int) -> FCurve:
    data = owner.animation_data or owner.animation_data_create()
    if data.action is None:
        data.action = bpy.data.actions.new(owner.name)
    if hasattr(data.action, "fcurve_ensure_for_datablock"):
        return data.action.fcurve_ensure_for_datablock(owner, path, index=index)
    return data.action.fcurves.new(path, index=index)
