"""The haptic scene of a traced frame, in numbers that survive a file and Blender's single precision.

Written, imported and written again, a frame gives the same bytes: properties are the shortest decimals of their single precision, what
stands where a file put it keeps that file's numbers, and contacts are found from the very shapes and poses that are written.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import fields, replace
from typing import Any, TypeVar

import bpy
import numpy as np
from bpy.types import Depsgraph, Object

from ...core.contacts.shapes import pose_matrix
from ...core.contacts.tracker import ContactTracker
from ...core.formats.recording import pair_of
from ...core.frame_result import FrameResult
from ...core.functions import ModulationFunction
from ...core.scene import Contact, HapticObject, HapticScene, Listener, Source, SourceKind, Vector
from ...core.signals import Pulse, Signal, Sine
from .. import session
from ..scene_reader import Reading
from .kept import kept_listener, kept_object, kept_scene, kept_source, near, same_pose

T = TypeVar("T")

AUTHORED = ("contact_tolerance", "impacts", "minimum_energy", "maximum_energy")
"""Properties of a scene that its settings in the file don't hold; they stand in its extras, under `EXTRAS`."""
EXTRAS = "blender"
MATERIAL = "material"
"""The name of an object's haptic material, in its extras."""


def scene_of_frame(scene: bpy.types.Scene, depsgraph: Depsgraph) -> HapticScene:
    """The haptic scene as it stands in the current frame, contacts included. Raises ValueError in words where nothing can be traced."""
    result = session.trace(scene, depsgraph)
    reading = session.of(scene).reading
    if result is None or reading is None:
        problems = session.problems_of(scene)
        raise ValueError(problems[0].message if problems else "Nothing is tagged: select objects and press Make Haptic")
    return scene_of_result(result, reading, scene)


def scene_of_result(result: FrameResult, reading: Reading, scene: bpy.types.Scene) -> HapticScene:
    """The haptic scene of a traced frame of ``scene`` and the reading that it was traced from. Lists are in the order of names."""
    written = written_frame(result, reading, scene)
    return replace(written, contacts=_contacts(written.objects, reading))


def written_frame(result: FrameResult, reading: Reading, scene: bpy.types.Scene) -> HapticScene:
    """`scene_of_result` without contacts."""
    found = {obj.name_full: obj for obj in bpy.data.objects}
    return HapticScene(
        objects=_by_name(_object(item, found.get(item.name)) for item in reading.posed_objects()),
        sources=_by_name(_source(item, found.get(item.name)) for item in result.sources),
        listeners=_by_name(_listener(item, found.get(item.name)) for item in result.listeners),
        settings=_shortest(reading.settings, ("threshold", "epsilon")),
        extras=_extras(scene, result.number),
    )


def within(scene: HapticScene, names: Collection[str]) -> HapticScene:
    """The part of a scene that is made of the objects, sources and listeners of these names."""
    objects = tuple(item for item in scene.objects if item.name in names)
    left = {item.name for item in objects}
    return replace(
        scene,
        objects=objects,
        contacts=tuple(item for item in scene.contacts if left.issuperset(pair_of(item))),
        sources=tuple(item for item in scene.sources if _is_within(item, names, left)),
        listeners=tuple(item for item in scene.listeners if item.name in names and item.object in left),
    )


def _is_within(source: Source, names: Collection[str], objects: Collection[str]) -> bool:
    if source.object not in objects or (source.second_object is not None and source.second_object not in objects):
        return False
    return source.name in names or source.kind is SourceKind.TEMPORARY


def _by_name(items: Any) -> tuple[Any, ...]:
    return tuple(sorted(items, key=lambda item: item.name))


def shortest(value: float) -> float:
    """The shortest decimal that is the same number in single precision: 0.1, not 0.10000000149011612."""
    return float(str(np.float32(value)))


def _shortest(item: T, names: Collection[str]) -> T:
    return replace(item, **{name: shortest(getattr(item, name)) for name in names})  # type: ignore[type-var]


def _vector(value: Vector) -> Vector:
    x, y, z = map(shortest, value)
    return x, y, z


def _object(item: HapticObject, obj: Object | None) -> HapticObject:
    kept = kept_object(obj.haptics.imported if obj is not None else "")
    material = obj.haptics.material.name if obj is not None else ""
    assert item.pose is not None
    pose = replace(item.pose, position=_vector(item.pose.position))
    if kept.pose is not None and same_pose(kept.pose, item.pose):
        pose = kept.pose
    mass = item.mass if item.mass is None or item.mass == kept.mass else shortest(item.mass)
    extras = {**kept.extras, MATERIAL: material} if material else dict(kept.extras)
    return replace(_shortest(item, ("kappa", "rho")), propagation=written_function(item.propagation), pose=pose, mass=mass, extras=extras)


def written_function(function: ModulationFunction) -> ModulationFunction:
    """With the numbers that single precision keeps."""
    numbers = [f.name for f in fields(function) if f.init and isinstance(getattr(function, f.name), float)]
    spectrum = replace(_shortest(function.spectrum, ("wave_speed",)), band_decays=tuple(map(shortest, function.spectrum.band_decays)))
    return replace(_shortest(function, numbers), spectrum=spectrum)


def _source(item: Source, obj: Object | None) -> Source:
    if obj is None:  # an impact of this frame
        return _shortest(item, ("amplitude",))
    kept = kept_source(obj.haptics.source.imported)
    position = kept.position if kept.position is not None and near(kept.position, item.position) else _vector(item.position)
    signal = item.signal if obj.haptics.source.signal in ("KEPT", "FILE") else _signal(item.signal)
    return replace(_shortest(item, ("amplitude", "priority")), position=position, signal=signal, extras=dict(kept.extras))


def _signal(signal: Signal | None) -> Signal | None:
    """With the frequency that the property shows."""
    match signal:
        case Sine(frequency=float(frequency)) | Pulse(frequency=float(frequency)):
            return replace(signal, frequency=shortest(frequency))
    return signal


def _listener(item: Listener, obj: Object | None) -> Listener:
    kept = kept_listener(obj.haptics.listener.imported if obj is not None else "")
    position = kept.position if kept.position is not None and near(kept.position, item.position) else _vector(item.position)
    return replace(_shortest(item, ("radius", "gain", "s_max")), position=position, extras=dict(kept.extras))


def _contacts(objects: tuple[HapticObject, ...], reading: Reading) -> tuple[Contact, ...]:
    """Between the objects as they are written."""
    body = {item.name: item for item in reading.bodies}
    bodies = [replace(body[item.name], shape=item.shape) for item in objects]
    transforms = np.array([pose_matrix(item.pose) for item in objects if item.pose is not None], dtype=np.float64).reshape(-1, 4, 4)
    frame = ContactTracker(bodies, reading.contact_settings).update(0.0, transforms)
    return frame.contacts.to_contacts([item.name for item in objects])


def _extras(scene: bpy.types.Scene, frame: int) -> dict[str, Any]:
    """What was imported with the scene, and what its properties say beyond its settings."""
    authored = {name: getattr(scene.haptics, name) for name in AUTHORED}
    rate = scene.render.fps / scene.render.fps_base
    return {
        **kept_scene(scene.haptics.imported),
        EXTRAS: {
            "frame": frame,
            "frame_start": scene.frame_start,
            "frame_rate": shortest(rate),
            **{name: shortest(value) if isinstance(value, float) else value for name, value in authored.items()},
        },
    }
