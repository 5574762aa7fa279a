"""The triggers of a source, from its properties."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Object, Scene

from ...core.scene.rule_table import Side
from ...core.scene.values import Pose, Trigger, TriggerKind
from ..blender.arrays import read_array
from ..blender.compatibility import fcurves_of
from ..blender.full_names import name_for, object_meant
from ..blender.time import seconds_of, stretching
from ..blender.units import metres_per_unit
from .present import evaluated_in, traced_layer
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
    if source.trigger_hit:
        triggers.append(Trigger(TriggerKind.HIT))
    if source.trigger_markers:
        frames = marker_frames(scene, source.trigger_markers)
        triggers.append(
            Trigger(TriggerKind.TIMES, tuple(seconds_of(scene, frame) for frame in frames))
        )
        if not frames:
            faults.append(
                (
                    "trigger_markers",
                    iface_("there is no timeline marker '{}'").format(source.trigger_markers),
                )
            )
    triggers += _passing(source, scene, faults)
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


def region_of(source: Any, scene: Scene) -> dict[str, Any]:
    """Pose and size of the region of a source, for its triggers in the current frame; a plane
    without a region."""
    region = object_meant(source.trigger_region, source.id_data)
    if region is None or region.name not in scene.objects:
        return {}
    (placed,) = evaluated_in([region], traced_layer(scene).depsgraph)
    place, rotation, scale = placed.matrix_world.decompose()
    corners = np.array([corner[:] for corner in region.bound_box])
    if region.type == "EMPTY":  # drawn as a cube of twice its display size
        corners = region.empty_display_size * np.array([(-1, -1, -1), (1, 1, 1)])
    low = corners.min(axis=0) * scale
    high = corners.max(axis=0) * scale
    centre = place + rotation.to_matrix() @ type(place)((low + high) / 2)
    metres = metres_per_unit(scene)
    return {
        "pose": Pose(tuple(centre * metres), tuple(rotation)),
        "size": tuple((np.abs(high - low) * metres).tolist()),
    }


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
        yield Trigger(TriggerKind.LEVEL, value=obj.haptics.source.trigger)
    elif curve is not None:
        keys = read_array(curve.keyframe_points, "co", 2)[:_MOST].tolist()
        above = [(frame, value) for frame, value in keys if value > 0]
        times, strengths = (
            (tuple(column) for column in zip(*above, strict=True)) if above else ((), ())
        )
        yield Trigger(
            TriggerKind.TIMES,
            tuple(seconds_of(scene, frame * stretching(scene)) for frame in times),
            tuple(min(s, 1.0) for s in strengths),
        )


def _passing(source: Any, scene: Scene, faults: list[tuple[str, str]]) -> Iterator[Trigger]:
    name, region = source.trigger_object, source.trigger_region
    side = Side(object=name)
    names = (
        (obj.name_full, name_for(obj, source.id_data))
        for obj in scene.objects
        if obj.haptics.enabled
    )
    found = [full for full, meant in names if meant != region and side.fits(meant, "")]
    if name and not found:
        faults.append(
            ("trigger_object", iface_("no haptic object '{}' can come into it").format(name))
        )
    if place := region_of(source, scene):
        yield from (Trigger(TriggerKind.PASSING, object=mover, **place) for mover in found)
    elif region or name:
        missing = (
            iface_("there is no object '{}' in this scene").format(region)
            if region
            else iface_("choose the region that it comes into")
        )
        faults.append(("trigger_region", missing))
