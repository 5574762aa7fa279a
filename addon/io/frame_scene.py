"""The haptic scene of a traced frame, with the exact numbers of the trace."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import Any

import bpy
from bpy.types import Context, Depsgraph, Object

from ...core.formats.export import Export
from ...core.formats.scene.recording import pair_of
from ...core.forms import JsonObject
from ...core.render.frame_result import FrameResult
from ...core.scene.values import (
    HapticObject,
    HapticScene,
    Listener,
    Source,
    SourceKind,
)
from ..blender.full_names import object_named
from ..blender.single_precision import shortest
from ..scene_reader.problem import why_untraced
from ..scene_reader.reading import Reading
from ..session import session
from .devices import is_muted, written_devices
from .materials import written_materials
from .written_objects import WrittenObjects

EXTRAS = "blender"
"""Key of the scene's extras that hold the frame of Blender's timeline."""
MUTED = "muted"
"""Key that is true in the extras of a listener without output."""


def current_scene(context: Context) -> HapticScene:
    """The current frame from its last trace, with the active impacts, or traced now. Raises
    ValueError with a message for the user."""
    scene = context.scene
    depsgraph = context.evaluated_depsgraph_get()
    result = session.result_of(scene)
    reading = session.of(scene).reading
    # A result without a propagation was read from a baked track.
    if (
        not scene.haptics.tracing
        or result is None
        or reading is None
        or "propagate" not in result.milliseconds
    ):
        return scene_of_frame(scene, depsgraph)
    return (
        scene_of_result(result, reading, scene)
        if result.number == scene.frame_current
        else scene_of_frame(scene, depsgraph)
    )


def scene_of_frame(scene: bpy.types.Scene, depsgraph: Depsgraph) -> HapticScene:
    """The haptic scene of the current frame, including contacts. Raises ValueError, with a message
    for the user, if it cannot be traced."""
    result = session.trace(scene, depsgraph)
    reading = session.of(scene).reading
    if result is None or reading is None:
        raise ValueError(why_untraced(session.problems_of(scene)))
    return scene_of_result(result, reading, scene)


def scene_of_result(result: FrameResult, reading: Reading, scene: bpy.types.Scene) -> HapticScene:
    """The haptic scene of a traced frame of ``scene`` and the reading that it was traced from.
    Lists are ordered by name."""
    return replace(
        written_frame(result, reading, scene, WrittenObjects().of(reading)),
        contacts=tuple(sorted(result.contacts.to_contacts(result.objects), key=pair_of)),
    )


def written_frame(
    result: FrameResult,
    reading: Reading,
    scene: bpy.types.Scene,
    objects: tuple[HapticObject, ...],
) -> HapticScene:
    """`scene_of_result` without contacts, with these ``objects`` of the frame."""
    shots = {shot.name for shot in result.shots}
    sources = [item for item in result.sources if item.name not in shots]
    sources += [item for item in reading.sources if item.triggers is not None]
    return HapticScene(
        objects=_by_name(objects),
        sources=_by_name(map(_source, sources)),
        listeners=_by_name(_listener(item, object_named(item.name)) for item in result.listeners),
        settings=reading.settings,
        extras=_extras(scene, result.number),
        rules=reading.contact_settings,
    )


def written_export(
    name: str,
    scene: bpy.types.Scene,
    frame: HapticScene,
    names: Collection[str] | None = None,
    **more: Any,
) -> Export:
    """A written frame of ``scene`` with materials and devices; ``names``: only those of
    these objects. Raises ValueError with a message for the user."""
    return Export(
        name,
        frame,
        devices=written_devices(scene, frame.listeners),
        materials=written_materials(scene, frame.objects, names is None),
        **more,
    )


def within(scene: HapticScene, names: Collection[str]) -> HapticScene:
    """The part of a scene with the objects, sources and listeners of these names."""
    objects = tuple(item for item in scene.objects if item.name in names)
    left = {item.name for item in objects}
    return replace(
        scene,
        objects=objects,
        contacts=tuple(item for item in scene.contacts if left.issuperset(pair_of(item))),
        sources=tuple(item for item in scene.sources if _is_within(item, names, left)),
        listeners=tuple(
            item for item in scene.listeners if item.name in names and item.object in left
        ),
    )


def _is_within(source: Source, names: Collection[str], objects: Collection[str]) -> bool:
    if source.object not in objects or (
        source.second_object is not None and source.second_object not in objects
    ):
        return False
    return source.name in names or source.rubs or source.kind is SourceKind.TEMPORARY


def _by_name(items: Any) -> tuple[Any, ...]:
    return tuple(sorted(items, key=lambda item: item.name))


def _source(item: Source) -> Source:
    return (
        item
        if not item.triggers
        else replace(item, triggers=tuple(t for t in item.triggers if t.value is None))
    )


def _listener(item: Listener, obj: Object | None) -> Listener:
    return replace(item, extras={**item.extras, MUTED: True}) if is_muted(obj) else item


def _extras(scene: bpy.types.Scene, frame: int) -> JsonObject:
    """The frame and frame rate of the scene."""
    rate = shortest(scene.render.fps / scene.render.fps_base)
    return {EXTRAS: {"frame": frame, "frame_start": scene.frame_start, "frame_rate": rate}}
