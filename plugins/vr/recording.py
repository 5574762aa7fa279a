"""Recorded hands as objects with keyframes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import bpy
import numpy as np
from bpy.types import Mesh, Object, Scene

from ...addon.blender.compatibility import ensure_fcurve
from ...addon.blender.units import metres_per_unit
from ...addon.io.property_writer import write_body, write_listener
from ...core.arrays import FloatArray
from ...core.contacts.shape_surface import surface
from ...core.scene.values import Listener
from .hands import NAMES, OBJECTS, PARTS, SHAPE, Grips

_LINEAR = 1  # interpolation


def add(scene: Scene, take: Mapping[int, Grips]) -> None:
    """Add the hands of a take to the scene: haptic objects of flesh with a listener each, and a key
    for each recorded frame of the timeline."""
    frames = sorted(take)
    collection = bpy.data.collections.new(f"VR Hands {frames[0]}-{frames[-1]}")
    scene.collection.children.link(collection)
    frame = scene.frame_current
    for (hand, name), item in zip(NAMES.items(), OBJECTS, strict=True):
        tracked = [number for number in frames if hand in take[number]]
        if tracked:
            obj = bpy.data.objects.new(name.rstrip("\0"), _mesh(name.rstrip("\0")))
            collection.objects.link(obj)
            obj.scale /= metres_per_unit(scene)
            write_body(obj.haptics, item)
            obj.haptics.surface = "SEEN"
            felt = Listener(obj.name, obj.name, body_part=PARTS[hand], radius=0.1)
            write_listener(obj.haptics.listener, felt)
            _move(obj, tracked, [take[number][hand] for number in tracked])
    scene.frame_set(frame)


def _move(
    obj: Object,
    frames: Sequence[int],
    grips: Sequence[tuple[tuple[float, float, float], tuple[float, float, float, float]]],
) -> None:
    """Key the grips of a hand at these frames."""
    obj.rotation_mode = "QUATERNION"
    places, rotations = (np.array(values) for values in zip(*grips, strict=True))
    # The same rotations without changes of sign, between which Blender would turn the hand round.
    flips = np.where((rotations[1:] * rotations[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    rotations[1:] *= np.cumprod(flips)[:, None]
    for path, values in (("location", places * obj.scale.x), ("rotation_quaternion", rotations)):
        for index, column in enumerate(values.T):
            _write_keys(ensure_fcurve(obj, path, index=index), frames, column)


def _write_keys(curve: Any, frames: Sequence[int], values: FloatArray) -> None:
    """Add keys to an F-curve, with straight lines between them."""
    places = np.column_stack([frames, values]).astype(np.float32)
    curve.keyframe_points.add(len(places))
    curve.keyframe_points.foreach_set("co", places.ravel())
    curve.keyframe_points.foreach_set(
        "interpolation", np.full(len(places), _LINEAR, dtype=np.int32)
    )
    curve.update()


def _mesh(name: str) -> Mesh:
    points, faces = surface(SHAPE)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], faces)
    mesh.validate()
    return mesh
