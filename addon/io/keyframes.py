"""Conversion of the changes of a recording to keyframes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from bpy.types import Object

from ...core.arrays import FloatArray
from ...core.contacts.shapes import pose_matrix
from ...core.formats.scene.poses import PoseRow
from ...core.formats.scene.recording import RecordedFrame, Recording
from ...core.scene.values import HapticScene, Listener, Pose, Source, SourceKind, Vector
from ..blender.compatibility import ensure_fcurve

Keys = dict[int, tuple[float, ...]]
"""Values by frame."""

LINEAR = 1
STILL = 1e-4
"""Largest motion [m] relative to its object of a source or listener that counts as fixed to it, because poses in files are rounded."""


@dataclass(frozen=True, slots=True)
class _Changes:
    """Changes by name: poses and (κ, ρ) of objects, amplitudes of sources, gains of listeners; positions and objects of sources and
    listeners by ``source <name>`` and ``listener <name>``; presence of objects and listeners: 1 or 0."""

    poses: dict[str, Keys]
    properties: dict[str, Keys]
    amplitudes: dict[str, Keys]
    gains: dict[str, Keys]
    places: dict[str, Keys]
    carriers: dict[str, str]
    objects_there: dict[str, Keys]
    listeners_there: dict[str, Keys]

    @classmethod
    def of(cls, scene: HapticScene, recording: Recording) -> _Changes:
        """The changes of a recording."""
        first = recording.frames[0].number
        changes = cls({}, {}, {}, {}, {}, {}, {}, {})
        begin = RecordedFrame(first, objects=scene.objects, sources=scene.sources, listeners=scene.listeners)
        for frame in (begin, *recording.frames):
            changes._add(frame, first)
        return changes

    def _add(self, change: RecordedFrame, first: int) -> None:
        number = change.number
        for name in change.removed_objects:
            self.objects_there[name][number] = (0.0,)
        for name in change.removed_listeners:
            self.listeners_there[name][number] = (0.0,)
        for item in change.objects:
            self.objects_there.setdefault(item.name, {first: (0.0,)})[number] = (1.0,)
            self.poses.setdefault(item.name, {})[number] = _row(item.pose)
            self.properties.setdefault(item.name, {})[number] = (item.kappa, item.rho)
        for listener in change.listeners:
            self.listeners_there.setdefault(listener.name, {first: (0.0,)})[number] = (1.0,)
            self.gains.setdefault(listener.name, {})[number] = (listener.gain,)
        for source in change.sources:
            before: Keys = {first: (0.0,)} if source.kind is SourceKind.PERSISTENT else {}
            self.amplitudes.setdefault(source.name, before)[number] = (source.amplitude,)
        for key, attached in _attached(change):
            self.places.setdefault(key, {})[number] = attached.position
            self.carriers.setdefault(key, attached.object)
        for name, row in change.poses.items():
            self.poses[name][number] = row
        for name, pair in change.properties.items():
            self.properties[name][number] = pair
        for name, amplitude in change.amplitudes.items():
            self.amplitudes[name][number] = (amplitude,)
        for name, positions in change.source_positions.items():
            self.places[f"source {name}"][number] = positions[0]
        for name, position in change.listener_positions.items():
            self.places[f"listener {name}"][number] = position
        for name, gain in change.gains.items():
            self.gains[name][number] = (gain,)


def _attached(change: RecordedFrame) -> Iterator[tuple[str, Source | Listener]]:
    """The sources and listeners that appear in a frame, by the keys of their positions."""
    yield from ((f"source {item.name}", item) for item in change.sources)
    yield from ((f"listener {item.name}", item) for item in change.listeners)


def write_keyframes(scene: HapticScene, recording: Recording, objects: Mapping[str, Object], attached: Mapping[str, Object]) -> list[str]:
    """Keyframes for all that changes; ``objects``: Blender's, by the names of haptic objects, ``attached``: those of sources and listeners,
    by ``source <name>`` and ``listener <name>``. Returns sentences about losses.
    """
    changes = _Changes.of(scene, recording)
    losses = [f"the function of {name} over time" for name in sorted({name for change in recording.frames for name in change.functions})]
    for name, keys in changes.poses.items():
        if len(keys) > 1:
            rows = _held(keys)
            _write(objects[name], {("location", k): (rows[0], rows[1][:, k]) for k in range(3)})
            turned = _continuous(rows[1][:, 3:])
            _write(objects[name], {("rotation_quaternion", k): (rows[0], turned[:, k]) for k in range(4)})
    _write_all(changes.properties, objects, "", ("haptics.kappa", "haptics.rho"))
    _write_all(changes.amplitudes, attached, "source ", ("haptics.source.amplitude",))
    _write_all(changes.gains, attached, "listener ", ("haptics.listener.gain",))
    _write_all(changes.objects_there, objects, "", ("haptics.enabled",))
    _write_all(changes.listeners_there, attached, "listener ", ("haptics.listener.enabled",))
    for key, keys in changes.places.items():
        carrier = changes.carriers[key]
        local = _local(keys, changes.poses[carrier])
        begin = next(iter(local.values()))
        drifts = np.abs(np.array(list(local.values())) - begin).max() > STILL
        if attached[key] is objects[carrier]:
            if drifts:
                losses.append(f"{key} moves apart from its object")
            continue
        attached[key].location = begin  # what begins later does so where its object has come to
        if drifts:
            times, values = _held(local)
            _write(attached[key], {("location", k): (times, values[:, k]) for k in range(3)})
    return losses


def _write_all(changes: Mapping[str, Keys], owners: Mapping[str, Object], prefix: str, paths: Sequence[str]) -> None:
    """Write keyframes of properties, one per column of the changes."""
    for name, keys in changes.items():
        if len(keys) > 1:
            times, values = _held(keys)
            _write(owners[prefix + name], {(path, 0): (times, values[:, k]) for k, path in enumerate(paths)})


def _row(pose: Pose | None) -> PoseRow:
    pose = pose or Pose()
    return (*pose.position, *pose.rotation)


def _held(keys: Keys) -> tuple[FloatArray, FloatArray]:
    """Frames (k,) and values (k, n), with an additional key before every change after a rest, so that the change takes one frame."""
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
    """The same rotations as quaternions without sign changes between consecutive ones."""
    signs = np.where(np.einsum("ij,ij->i", rotations[1:], rotations[:-1]) < 0, -1.0, 1.0)
    return rotations * np.concatenate([[1.0], np.cumprod(signs)])[:, None]


def _local(places: Keys, poses: Keys) -> Keys:
    """Positions in the space of their objects, whenever either moves."""
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
        curve = ensure_fcurve(obj, path, index=index)
        curve.keyframe_points.add(len(times))
        curve.keyframe_points.foreach_set("co", np.column_stack([times, values]).astype(np.float32).ravel())
        curve.keyframe_points.foreach_set("interpolation", np.full(len(times), LINEAR, dtype=np.int32))
        curve.update()
