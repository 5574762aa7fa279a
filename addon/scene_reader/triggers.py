"""The triggers of a source, from its properties."""

from __future__ import annotations

from collections.abc import Iterator

from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Object, Scene

from ...core.scene.rule_table import Side
from ...core.scene.values import Trigger
from ..blender.arrays import read_array
from ..blender.compatibility import fcurves_of
from ..blender.time import seconds_of, stretching
from .problem import Problem

PATH = "haptics.source.trigger"
_MOST = 100_000
"""Largest number of keyframes that are read."""


def read_triggers(obj: Object, scene: Scene) -> tuple[tuple[Trigger, ...] | None, list[Problem]]:
    """The triggers of a source, None if it plays without triggers, and their problems, each with
    its property."""
    source = obj.haptics.source
    if not source.one_shot:
        return None, []
    faults: list[tuple[str, str]] = []
    triggers = [*_of_property(obj, scene)]
    if source.trigger_markers:
        frames = marker_frames(scene, source.trigger_markers)
        triggers.append(Trigger(tuple(seconds_of(scene, frame) for frame in frames)))
        if not frames:
            faults.append(
                (
                    "trigger_markers",
                    iface_("there is no timeline marker '{}'").format(source.trigger_markers),
                )
            )
    if not triggers and not faults:
        faults.append(
            (
                "trigger",
                iface_("it never plays: insert keyframes of Trigger, or choose something below"),
            )
        )
    return tuple(triggers), [Problem(obj.name_full, message, (name, 0)) for name, message in faults]


def marker_frames(scene: Scene, pattern: str) -> tuple[int, ...]:
    """The frames of the timeline markers that match a pattern."""
    side = Side(object=pattern)
    return tuple(
        sorted(marker.frame for marker in scene.timeline_markers if side.fits(marker.name, ""))
    )


def _of_property(obj: Object, scene: Scene) -> Iterator[Trigger]:
    """Triggers from keyframes of the property if it has any, otherwise from its rising values by a
    driver, F-curve modifiers or the NLA."""
    data = obj.animation_data
    curve = next((c for c in fcurves_of(obj) if c.data_path == PATH and not c.mute), None)
    driver = (
        next((d for d in data.drivers if d.data_path == PATH and not d.mute), None)
        if data is not None
        else None
    )
    if (
        driver is not None
        or (curve is not None and len(curve.modifiers))
        or (data is not None and len(data.nla_tracks))
    ):
        yield Trigger(value=obj.haptics.source.trigger)
    elif curve is not None:
        keys = read_array(curve.keyframe_points, "co", 2)[:_MOST].tolist()
        above = [(frame, value) for frame, value in keys if value > 0]
        times, strengths = (
            (tuple(column) for column in zip(*above, strict=True)) if above else ((), ())
        )
        yield Trigger(
            tuple(seconds_of(scene, frame * stretching(scene)) for frame in times),
            tuple(min(s, 1.0) for s in strengths),
        )
