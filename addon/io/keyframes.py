"""Conversion of the changes of a recording to keyframes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from bpy.types import Object

from ...core.arrays import FloatArray
from ...core.contacts.shapes import pose_matrix
from ...core.formats.scene.recording import RecordedFrame, Recording
from ...core.scene.values import HapticScene, Listener, Pose, Source, SourceKind, Vector
from ..blender.arrays import write_keys
from ..blender.compatibility import ensure_fcurve

Keys = dict[int, tuple[float, ...]]
"""Values by frame."""

STILL = 1e-4
"""Largest motion [m] relative to its object of a source or listener that counts as fixed to it,
because poses in files are rounded."""

POSE, PLACE = "pose", "place"
KAPPA, RHO, ENABLED = "haptics.kappa", "haptics.rho", "haptics.enabled"
AMPLITUDE = "haptics.source.amplitude"
GAIN = "haptics.listener.gain"
LISTENS = "haptics.listener.enabled"
"""What changes: a pose, a position, or a property by its data path."""


def write_keyframes(
    scene: HapticScene,
    recording: Recording,
    objects: Mapping[str, Object],
    attached: Mapping[str, Object],
) -> list[str]:
    """Keyframes for all that changes; ``objects``: Blender's, by the names of haptic objects,
    ``attached``: those of sources and listeners, by ``source <name>`` and ``listener <name>``.
    Returns sentences about losses.
    """
    begin = RecordedFrame(
        recording.frames[0].number,
        objects=scene.objects,
        sources=scene.sources,
        listeners=scene.listeners,
    )
    frames = (begin, *recording.frames)
    changes = _changes(frames)
    owners = {**{f"object {name}": obj for name, obj in objects.items()}, **attached}
    losses = [
        f"the function of {name} over time"
        for name in sorted({name for change in recording.frames for name in change.functions})
    ]
    for key, keys in changes[POSE].items():
        if len(keys) > 1:
            times, rows = _held(keys)
            # An imported object has the scale of a metre.
            _write(owners[key], "location", times, rows[:, :3] * owners[key].scale.x)
            _write(owners[key], "rotation_quaternion", times, _continuous(rows[:, 3:]))
    for path in (KAPPA, RHO, AMPLITUDE, GAIN, ENABLED, LISTENS):
        for key, keys in changes[path].items():
            if len(keys) > 1:
                _write(owners[key], path, *_held(keys))
    carriers = {
        owner: item.object for change in reversed(frames) for owner, item in _attached(change)
    }
    for key, keys in changes[PLACE].items():
        carrier = f"object {carriers[key]}"
        local = _local(keys, changes[POSE][carrier])
        first = next(iter(local.values()))
        drifts = np.abs(np.array(list(local.values())) - first).max() > STILL
        if attached[key] is owners[carrier]:
            if drifts:
                losses.append(f"{key} moves apart from its object")
            continue
        attached[key].location = first  # relative to where the object is when it begins
        if drifts:
            _write(attached[key], "location", *_held(local))
    return losses


def _changes(frames: Sequence[RecordedFrame]) -> Mapping[str, Mapping[str, Keys]]:
    """Keys, values by frame, of all that changes: by property, then by owner, which is ``object
    <name>``, ``source <name>`` or ``listener <name>``.

    An owner that appears in a later frame gets a key in the first frame in which it is off: objects
    and listeners are not haptic, persistent sources have amplitude 0."""
    temporary = {
        f"source {item.name}"
        for frame in frames
        for item in frame.sources
        if item.kind is not SourceKind.PERSISTENT
    }
    found: dict[str, dict[str, Keys]] = defaultdict(lambda: defaultdict(dict))
    for frame in frames:
        for what, owner, *values in _changed(frame):
            keys = found[what][owner]
            if what in (AMPLITUDE, ENABLED, LISTENS) and owner not in temporary:
                keys.setdefault(frames[0].number, (0.0,))
            keys[frame.number] = tuple(values)
    return found


def _changed(change: RecordedFrame) -> Iterator[tuple[Any, ...]]:
    """What changes in a frame, its owner, and the values."""
    yield from ((ENABLED, f"object {name}", 0.0) for name in change.removed_objects)
    yield from ((LISTENS, f"listener {name}", 0.0) for name in change.removed_listeners)
    for item in change.objects:
        yield ENABLED, f"object {item.name}", 1.0
        pose = item.pose or Pose()
        yield POSE, f"object {item.name}", *pose.position, *pose.rotation
        yield KAPPA, f"object {item.name}", item.kappa
        yield RHO, f"object {item.name}", item.rho
    for listener in change.listeners:
        yield LISTENS, f"listener {listener.name}", 1.0
        yield GAIN, f"listener {listener.name}", listener.gain
    yield from ((AMPLITUDE, f"source {source.name}", source.amplitude) for source in change.sources)
    yield from ((PLACE, owner, *item.position) for owner, item in _attached(change))
    yield from ((POSE, f"object {name}", *row) for name, row in change.poses.items())
    for name, (kappa, rho) in change.properties.items():
        yield KAPPA, f"object {name}", kappa
        yield RHO, f"object {name}", rho
    yield from (
        (AMPLITUDE, f"source {name}", amplitude) for name, amplitude in change.amplitudes.items()
    )
    yield from (
        (PLACE, f"source {name}", *positions[0])
        for name, positions in change.source_positions.items()
    )
    yield from (
        (PLACE, f"listener {name}", *position)
        for name, position in change.listener_positions.items()
    )
    yield from ((GAIN, f"listener {name}", gain) for name, gain in change.gains.items())


def _attached(change: RecordedFrame) -> Iterator[tuple[str, Source | Listener]]:
    """The sources and listeners that appear in a frame, by owner as in `_changes`."""
    yield from ((f"source {item.name}", item) for item in change.sources)
    yield from ((f"listener {item.name}", item) for item in change.listeners)


def _held(keys: Keys) -> tuple[FloatArray, FloatArray]:
    """Frames (k,) and values (k, n), with an additional key before every change after a rest, so
    that the change takes one frame."""
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
        pose = poses.get(frame, pose)
        place = places.get(frame, place)
        x, y, z, a, b, c, d = pose
        result[frame] = local_place(place, Pose((x, y, z), (a, b, c, d)))
    return result


def local_place(place: Sequence[float], pose: Pose | None) -> Vector:
    """A world position in the space of a pose."""
    matrix = pose_matrix(pose or Pose())
    x, y, z = (matrix[:3, :3].T @ (np.array(place) - matrix[:3, 3])).tolist()
    return x, y, z


def _write(obj: Object, path: str, times: FloatArray, values: FloatArray) -> None:
    """Keys of a property with straight lines between them; ``values``: (k, n), a curve per
    column."""
    for index, column in enumerate(values.T):
        write_keys(ensure_fcurve(obj, path, index=index), times, column)
