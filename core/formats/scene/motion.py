"""Compressed poses of objects that move in many consecutive frames.

In a file a motion is ``{"object", "frame", "count", "poses"}``: the poses of ``count`` consecutive
frames, the first of which is ``frame``. They are a table of ``count`` rows of integers in units of
1e-5 (position x, y, z in metres, rotation w, x, y, z). Each column is replaced by its second
difference (the first row is unchanged, the second is the first difference, then a[n] - 2 a[n - 1] +
a[n - 2]). The table is read column by column, signs are folded (n to 2 n, -n to 2 n - 1), and the
little-endian 64 bit integers are written as byte planes: the first byte of each, then the second of
each. The result is compressed by zlib (RFC 1950) and encoded in base64.
"""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...arrays import IntArray
from ...forms import Form, JsonObject
from ...scene.references import PlacedError, require_known
from .recording import PER_UNIT, PoseRow, Poses, RecordedFrame, pose_row

FEWEST = 8
"""Minimum number of consecutive frames of a motion; shorter ones are written in the frames."""
MANY = 20_000
"""Number of poses from which a recording has motions; fewer are written in the frames, where they
are readable."""
MOST = 4_500_000
"""Maximum number of poses that are read."""

_FARTHEST = 10**9 * PER_UNIT
_LEVEL = 6


def packed(frames: Sequence[RecordedFrame]) -> tuple[list[JsonObject], Sequence[RecordedFrame]]:
    """Motions in the order of the objects' names, and the frames without the poses in these
    motions.

    There are no motions if there are fewer than ``MANY`` poses, or poses that are not multiples of
    1e-5.
    """
    if sum(len(frame.poses) for frame in frames) < MANY or not all(
        _is_rounded(frame.poses) for frame in frames
    ):
        return [], frames
    names = sorted({name for frame in frames for name in frame.poses})
    number = {name: k for k, name in enumerate(names)}
    every = [Poses.of(frame.poses) for frame in frames]
    objects = np.array([number[name] for poses in every for name in poses.names], dtype=np.int64)
    rows = np.repeat(np.arange(len(frames)), [len(poses) for poses in every])
    times = np.array([frame.number for frame in frames], dtype=np.int64)[rows]
    ticks = np.concatenate([poses.ticks for poses in every])
    order = np.lexsort((times, objects))
    objects = objects[order]
    rows = rows[order]
    times = times[order]
    starts = np.flatnonzero(
        np.concatenate([[True], (np.diff(objects) != 0) | (np.diff(times) != 1)])
    )
    motions: list[JsonObject] = []
    left: dict[int, dict[str, PoseRow]] = {}
    for first, last in zip(starts.tolist(), [*starts[1:].tolist(), len(objects)], strict=True):
        name = names[objects[first]]
        run = ticks[order[first:last]]
        if last - first >= FEWEST:
            motions.append(
                {
                    "object": name,
                    "frame": int(times[first]),
                    "count": last - first,
                    "poses": encoded(run),
                }
            )
            continue
        for row, pose in zip(rows[first:last].tolist(), run, strict=True):
            left.setdefault(row, {})[name] = pose_row(pose)
    return motions, [replace(frame, poses=left.get(row, {})) for row, frame in enumerate(frames)]


def _is_rounded(poses: Mapping[str, PoseRow]) -> bool:
    """Whether poses are multiples of 1e-5."""
    if isinstance(poses, Poses) or not poses:
        return True
    values = np.array(list(poses.values()), dtype=np.float64)
    return bool(
        (np.abs(values) < 10**9).all() and (np.rint(values * PER_UNIT) / PER_UNIT == values).all()
    )


def unpacked(forms: Sequence[Form], objects: set[str]) -> dict[int, Poses]:
    """The poses of validated motions by frame. Raises PlacedError."""
    total = 0
    tables = []
    counts = [int(form["count"]) for form in forms]  # 3.0 is an integer in JSON Schema
    for i, (form, count) in enumerate(zip(forms, counts, strict=True)):
        require_known(form["object"], objects, "object", ("motions", i, "object"))
        total += count
        if total > MOST:
            raise PlacedError(("motions", i, "count"), f"more than {MOST} poses")
        try:
            table = decoded(form["poses"], count)
        except ValueError as error:
            raise PlacedError(("motions", i, "poses"), str(error)) from None
        if (np.abs(table) > _FARTHEST).any():
            raise PlacedError(("motions", i, "poses"), "beyond 1e9 metres")
        if not table[:, 3:].any(axis=1).all():
            raise PlacedError(("motions", i, "poses"), "a quaternion of length 0 is no rotation")
        tables.append(table)
    if not tables:
        return {}
    names = [form["object"] for form in forms]
    times = np.concatenate(
        [int(form["frame"]) + np.arange(count) for form, count in zip(forms, counts, strict=True)]
    )
    motions = np.repeat(np.arange(len(forms)), counts)
    ticks = np.concatenate(tables)
    order = np.argsort(times, kind="stable")
    numbers, starts = np.unique(times[order], return_index=True)
    result = {}
    for number, rows in zip(numbers.tolist(), np.split(order, starts[1:]), strict=True):
        moving = tuple(names[k] for k in motions[rows].tolist())
        if len(set(moving)) < len(moving):
            twice = next(name for name in moving if moving.count(name) > 1)
            raise PlacedError(("motions",), f"{twice!r} has two poses in frame {number}")
        result[number] = Poses(moving, ticks[rows])
    return result


def encoded(ticks: IntArray) -> str:
    """A table (n, 7) of integers as text."""
    table = ticks.copy()
    table[1:] -= ticks[:-1]
    table[2:] -= ticks[1:-1] - ticks[:-2]
    column = table.T.ravel()
    folded = ((column << 1) ^ (column >> 63)).astype("<i8")
    planes = folded.view(np.uint8).reshape(-1, 8).T
    return base64.b64encode(zlib.compress(planes.tobytes(), _LEVEL)).decode("ascii")


def decoded(text: str, count: int) -> IntArray:
    """The table (count, 7) of a text. Raises ValueError."""
    try:
        data = base64.b64decode(text, validate=True)
    except ValueError:
        raise ValueError("is not base64") from None
    size = 7 * 8 * count
    unpacker = zlib.decompressobj()
    try:
        planes = unpacker.decompress(data, size + 1)
    except zlib.error as error:
        raise ValueError(f"is not compressed by zlib: {error}") from None
    if len(planes) != size or not unpacker.eof or unpacker.unused_data:
        raise ValueError(f"does not hold {count} poses")
    folded = np.frombuffer(planes, dtype=np.uint8).reshape(8, -1).T.copy().view("<u8").ravel()
    column = (folded >> np.uint64(1)).astype(np.int64) ^ -(folded & np.uint64(1)).astype(np.int64)
    return np.cumsum(
        np.concatenate(
            [column.reshape(7, count).T[:1], np.cumsum(column.reshape(7, count).T[1:], axis=0)]
        ),
        axis=0,
    )
