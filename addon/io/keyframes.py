"""What changes from frame to frame, as keyframes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import bpy
import numpy as np
from bpy.types import Object

from ...core.arrays import FloatArray
from ...core.contacts.shapes import pose_matrix
from ...core.formats.scene.poses import PoseRow
from ...core.formats.scene.recording import Recording
from ...core.scene.values import HapticScene, Pose, Vector

Keys = dict[int, tuple[float, ...]]
"""By frame."""

LINEAR = 1
STILL = 1e-4
"""Metres that something may wander on the object that carries it and still count as fixed to it: poses in files are rounded."""


def write_keyframes(scene: HapticScene, recording: Recording, objects: Mapping[str, Object], attached: Mapping[str, Object]) -> list[str]:
    """Keyframes for all that changes; ``objects``: Blender's, by the names of haptic objects, ``attached``: those of sources and listeners,
    by ``source <name>`` and ``listener <name>``. What could not be carried over, in words."""
    first = recording.frames[0].number
    poses: dict[str, Keys] = {item.name: {first: _row(item.pose)} for item in scene.objects}
    properties: dict[str, Keys] = {item.name: {first: (item.kappa, item.rho)} for item in scene.objects}
    amplitudes: dict[str, Keys] = {item.name: {first: (item.amplitude,)} for item in scene.sources}
    gains: dict[str, Keys] = {item.name: {first: (item.gain,)} for item in scene.listeners}
    places: dict[str, Keys] = {f"source {item.name}": {first: item.position} for item in scene.sources}
    places |= {f"listener {item.name}": {first: item.position} for item in scene.listeners}
    carriers = {f"source {item.name}": item.object for item in scene.sources}
    carriers |= {f"listener {item.name}": item.object for item in scene.listeners}
    for change in recording.frames:
        number = change.number
        for source in change.sources:
            amplitudes[source.name] = {number: (source.amplitude,)}
            places[f"source {source.name}"] = {number: source.position}
            carriers[f"source {source.name}"] = source.object
        for name, row in change.poses.items():
            poses[name][number] = row
        for name, pair in change.properties.items():
            properties[name][number] = pair
        for name, amplitude in change.amplitudes.items():
            amplitudes[name][number] = (amplitude,)
        for name, positions in change.source_positions.items():
            places[f"source {name}"][number] = positions[0]
        for name, position in change.listener_positions.items():
            places[f"listener {name}"][number] = position
        for name, gain in change.gains.items():
            gains[name][number] = (gain,)
    losses = [f"the function of {name} over time" for name in sorted({name for change in recording.frames for name in change.functions})]
    for name, keys in poses.items():
        if len(keys) > 1:
            rows = _held(keys)
            _write(objects[name], {("location", k): (rows[0], rows[1][:, k]) for k in range(3)})
            turned = _continuous(rows[1][:, 3:])
            _write(objects[name], {("rotation_quaternion", k): (rows[0], turned[:, k]) for k in range(4)})
    for name, keys in properties.items():
        if len(keys) > 1:
            times, values = _held(keys)
            _write(objects[name], {("haptics.kappa", 0): (times, values[:, 0]), ("haptics.rho", 0): (times, values[:, 1])})
    for name, keys in amplitudes.items():
        if len(keys) > 1:
            times, values = _held(keys)
            _write(attached[f"source {name}"], {("haptics.source.amplitude", 0): (times, values[:, 0])})
    for name, keys in gains.items():
        if len(keys) > 1:
            times, values = _held(keys)
            _write(attached[f"listener {name}"], {("haptics.listener.gain", 0): (times, values[:, 0])})
    for key, keys in places.items():
        local = _local(keys, poses[carriers[key]])
        begin = next(iter(local.values()))
        drifts = np.abs(np.array(list(local.values())) - begin).max() > STILL
        if attached[key] is objects[carriers[key]]:
            if drifts:
                losses.append(f"{key} moves apart from its object")
            continue
        attached[key].location = begin  # what begins later does so where its object has come to
        if not drifts:
            continue
        times, values = _held(local)
        _write(attached[key], {("location", k): (times, values[:, k]) for k in range(3)})
    return losses


def _row(pose: Pose | None) -> PoseRow:
    pose = pose or Pose()
    return (*pose.position, *pose.rotation)


def _held(keys: Keys) -> tuple[FloatArray, FloatArray]:
    """Frames (k,) and values (k, n), with a key more before every change after a rest, so that it changes from one frame to the next."""
    times: list[int] = []
    values: list[tuple[float, ...]] = []
    for frame, value in keys.items():
        if times and frame > times[-1] + 1:
            times.append(frame - 1)
            values.append(values[-1])
        times.append(frame)
        values.append(value)
    return np.array(times, dtype=np.float64), np.array(values, dtype=np.float64)


def _continuous(rotations: FloatArray) -> FloatArray:
    """The same rotations by quaternions none of which is far from the one before."""
    signs = np.where(np.einsum("ij,ij->i", rotations[1:], rotations[:-1]) < 0, -1.0, 1.0)
    return rotations * np.concatenate([[1.0], np.cumprod(signs)])[:, None]


def _local(places: Keys, poses: Keys) -> Keys:
    """Places in the space of what carries them, whenever either moves."""
    result: Keys = {}
    first = next(iter(places))
    place = places[first]
    pose = poses[max((frame for frame in poses if frame <= first), default=next(iter(poses)))]
    for frame in sorted({*places, *(frame for frame in poses if frame > first)}):
        pose, place = poses.get(frame, pose), places.get(frame, place)
        x, y, z, a, b, c, d = pose
        result[frame] = local_place(place, Pose((x, y, z), (a, b, c, d)))
    return result


def local_place(place: Sequence[float], pose: Pose | None) -> Vector:
    """A world position in the space of a pose."""
    matrix = pose_matrix(pose or Pose())
    x, y, z = (matrix[:3, :3].T @ (np.array(place) - matrix[:3, 3])).tolist()
    return x, y, z


def _write(obj: Object, curves: Mapping[tuple[str, int], tuple[FloatArray, FloatArray]]) -> None:
    for (path, index), (times, values) in curves.items():
        curve = _curve(obj, path, index)
        curve.keyframe_points.add(len(times))
        curve.keyframe_points.foreach_set("co", np.column_stack([times, values]).astype(np.float32).ravel())
        curve.keyframe_points.foreach_set("interpolation", np.full(len(times), LINEAR, dtype=np.int32))
        curve.update()


def _curve(obj: Object, path: str, index: int) -> Any:
    """A new F-curve of a property."""
    data = obj.animation_data or obj.animation_data_create()
    if data.action is None:
        data.action = bpy.data.actions.new(f"{obj.name}Action")
    if hasattr(data.action, "fcurve_ensure_for_datablock"):
        return data.action.fcurve_ensure_for_datablock(obj, path, index=index)
    return data.action.fcurves.new(path, index=index)
