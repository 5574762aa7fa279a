"""Conversion of the changes of a recording to keyframes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from bpy.types import Object

from ...core.arrays import FloatArray
from ...core.contacts.shapes import pose_matrix
from ...core.formats.scene.recording import CHANGES, RecordedFrame, Recording
from ...core.scene.values import HapticScene, Pose, SourceKind, Vector
from ..blender.arrays import write_keys
from ..blender.compatibility import ensure_fcurve

Keys = dict[int, tuple[float, ...]]
"""Values by frame."""

STILL = 1e-4
"""Largest motion [m] relative to its object of a source or listener that counts as fixed to it,
because poses in files are rounded."""

POSE, PLACE = "pose", "position"
PATHS = {
    ("object", "enabled"): "haptics.enabled",
    ("object", "kappa"): "haptics.kappa",
    ("object", "rho"): "haptics.rho",
    ("source", "amplitude"): "haptics.source.amplitude",
    ("listener", "enabled"): "haptics.listener.enabled",
    ("listener", "gain"): "haptics.listener.gain",
}
"""Data paths of properties, by kind of item and its field."""


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
    for path in PATHS.values():
        for key, keys in changes[path].items():
            if len(keys) > 1:
                _write(owners[key], path, *_held(keys))
    carriers = {
        f"{kind} {item.name}": item.object
        for change in reversed(frames)
        for kind, items in (("source", change.sources), ("listener", change.listeners))
        for item in items
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
    """Keys, values by frame, of all that changes: by data path or field, then by owner, which is
    ``object <name>``, ``source <name>`` or ``listener <name>``.

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
        for kind, name, field, value in _changed(frame):
            owner = f"{kind} {name}"
            keys = found[PATHS.get((kind, field), field)][owner]
            if field in ("amplitude", "enabled") and owner not in temporary:
                keys.setdefault(frames[0].number, (0.0,))
            keys[frame.number] = _row(value)
    return found


def _changed(change: RecordedFrame) -> Iterator[tuple[str, str, str, Any]]:
    """What changes in a frame: kind and name of the item, its field and the value. An item that
    appears is enabled, one that disappears is not."""
    for kind in ("object", "source", "listener"):
        for name in getattr(change, f"removed_{kind}s", ()):
            yield kind, name, "enabled", 0.0
        for item in getattr(change, f"{kind}s"):
            yield kind, item.name, "enabled", 1.0
            for of, fields in CHANGES.values():
                if of == f"{kind}s":
                    yield from ((kind, item.name, field, getattr(item, field)) for field in fields)
    for key, (of, fields) in CHANGES.items():
        for name, value in getattr(change, key).items():
            values = value if len(fields) > 1 else (value,)
            for field, part in zip(fields, values, strict=False):
                yield of[:-1], name, field, part


def _row(value: Any) -> tuple[Any, ...]:
    """The numbers of a value: of a pose position and rotation."""
    if value is None or isinstance(value, Pose):
        pose = value or Pose()
        return (*pose.position, *pose.rotation)
    return value if isinstance(value, tuple) else (value,)


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
