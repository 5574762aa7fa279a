"""``.tact`` (bHaptics): one file per device, with the strength of each of its motors in steps of 20
ms. Read as one vibration per body part, the strongest of its motors."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ...core.arrays import FloatArray, IntArray
from ...core.formats.io.budget import Budget
from ...core.formats.io.error import FormatError
from ...core.formats.io.file_names import file_stems
from ...core.formats.io.json_text import write_compact
from ...core.formats.io.schema import validate
from ...core.formats.io.strict_json import read_json
from ...core.formats.tracks.fidelity import Progress
from ...core.formats.tracks.listener_tracks import Tracks
from ...core.formats.tracks.track_export import TrackExport, body_part_of, common_losses, credit
from ...core.formats.tracks.vibration_file import VibrationFile
from ...core.forms import Form, JsonObject
from ...core.scene.body import BODY_PARTS
from ..keyframes.carrier import Carrier
from ..keyframes.channel import KeyframedChannel
from ..keyframes.comparison import Comparison, Kind, Measures
from ..keyframes.envelopes import compare_steps, vibration_envelope
from ..keyframes.left_out import without_damaged
from .motors import DEVICES, region

INTERVAL = 20
"""Step of strengths (milliseconds)."""

FREQUENCY = 100.0
"""Frequency of the vibrations (hertz): the format has only strengths."""
MORE = 0.53
"""What motors that play a point between them have beyond their barycentric coordinates."""
LONGEST = 3_600_000
"""Longest file (milliseconds)."""
MOST_STEPS = 5_000_000
"""Steps of all effects."""

_AT_ONCE = 4096
_TINY = 1e-9
_ROUNDING = 1e-6
LONGEST_NUMBER = 32
"""Characters of a number that is written as text."""

_FADES: Mapping[str, Callable[[FloatArray], FloatArray]] = {
    "FADE_IN": lambda share: share,
    "FADE_OUT": lambda share: 1 - share,
    "FADE_IN_OUT": lambda share: 1 - np.abs(2 * share - 1),
    "NONE": np.ones_like,
}
"""Amplitude by the part of an interval that has passed, both 0 to 1, for each fade."""
_LISTS = ("dotMode", "pathMode")
_TRACK = ("project", "tracks", "*")
_SCHEMA = Path(__file__).with_name("tact.schema.json")
_PARTS = (_TRACK, (*_TRACK, "effects", "*"))
_NUMBERS: Mapping[str, Callable[[str], float]] = {
    "index": int,
    "intensity": float,
    "x": float,
    "y": float,
    "time": float,
}
_LAYOUTS = {position: places for layout in DEVICES.values() for position, places in layout.items()}


def motors(tracks: Tracks) -> dict[str, dict[int, list[int]]]:
    """For each position and motor index, the numbers of the listeners that it represents."""
    result: dict[str, dict[int, list[int]]] = {}
    for number, listener in enumerate(tracks.listeners):
        part = body_part_of(listener)
        if part is not None and part.bhaptics in _LAYOUTS:
            for index in region(part, _LAYOUTS[part.bhaptics]):
                result.setdefault(part.bhaptics, {}).setdefault(index, []).append(number)
    return result


def _together(driven: Mapping[str, Mapping[int, list[int]]]) -> dict[int, list[int]]:
    """For each listener that is represented by a motor, the listeners that one represents."""
    return {
        number: numbers
        for indices in driven.values()
        for numbers in indices.values()
        for number in numbers
    }


def loss(export: TrackExport, options: Form) -> Iterator[str]:
    """What the files do not carry, one sentence each. Raises ValueError if no listener is at a part
    of the body where a device is worn."""
    tracks = export.need_tracks()
    driven = _together(motors(tracks))
    if not driven:
        raise ValueError(
            "tracks: no listener is where a bHaptics device is worn: give one such a body part "
            "(hand.L, chest.L, upper_back.L, ...)"
        )
    absent = [
        listener.name for number, listener in enumerate(tracks.listeners) if number not in driven
    ]
    yield from common_losses(tracks, body=True)
    yield f"frequencies: the strength every {INTERVAL} ms remains, in {options['levels']} steps"
    if absent:
        yield f"listeners where no device is worn: {', '.join(absent)}"


def comparison(tracks: Tracks, options: Form, progress: Progress) -> Comparison:
    """What compares the files with the tracks."""
    return Comparison(tracks, Measures(Kind.LEVEL), progress)


def write(export: TrackExport, folder: Path, options: Form, measured: Comparison) -> list[Path]:
    """Write ``<scene>.<device>.tact`` for each device that a listener wears."""
    tracks = export.need_tracks()
    driven = motors(tracks)
    devices = [
        device
        for device, layout in DEVICES.items()
        if any(position in driven for position in layout)
    ]
    stems = file_stems(f"{export.name}.{device}" for device in devices)
    rows = [tracks.row(number) for number in range(len(tracks.listeners))]
    levels = np.array([vibration_envelope(row, INTERVAL / 1000)[0] for row in rows])
    steps = np.rint(np.clip(levels, 0.0, 1.0) * options["levels"]).astype(np.int64)
    shared = _together(driven)
    for number in range(len(rows)):
        played = steps[shared[number]].max(axis=0) if number in shared else np.zeros(steps.shape[1])
        compare_steps(number, played / options["levels"], INTERVAL / 1000, measured)
    files = []
    for device, stem in zip(devices, stems, strict=True):
        modes = {
            position: _mode(driven.get(position, {}), steps, options["levels"])
            for position in DEVICES[device]
        }
        document = _document(export, tracks, device, stem, modes)
        files.append(write_compact(folder / f"{stem}.tact", document))
    return files


def _mode(indices: Mapping[int, list[int]], steps: IntArray, levels: int) -> JsonObject:
    return {
        "mode": "DOT_MODE",
        "dotMode": {"dotConnected": False, "feedback": list(_feedback(indices, steps, levels))},
        "pathMode": {
            "feedback": [
                {
                    "movingPattern": "CONST_TDM",
                    "playbackType": "NONE",
                    "visible": True,
                    "pointList": [],
                }
            ]
        },
    }


def _feedback(
    indices: Mapping[int, list[int]], steps: IntArray, levels: int
) -> Iterator[JsonObject]:
    """Intervals in which no motor changes, except silent ones."""
    if not indices or not steps.shape[1]:
        return
    strengths = np.array([steps[numbers].max(axis=0) for numbers in indices.values()])
    changes = np.flatnonzero(np.append(True, np.any(np.diff(strengths, axis=1), axis=0)))
    for first, last in zip(
        changes.tolist(), np.append(changes[1:], strengths.shape[1]).tolist(), strict=True
    ):
        points = [
            {"index": index, "intensity": round(strength / levels, 3)}
            for index, strength in zip(indices, strengths[:, first].tolist(), strict=True)
            if strength
        ]
        if points:
            yield {
                "startTime": first * INTERVAL,
                "endTime": last * INTERVAL,
                "playbackType": "NONE",
                "pointList": points,
            }


def _document(
    export: TrackExport, tracks: Tracks, device: str, name: str, modes: JsonObject
) -> JsonObject:
    """The document of a file for one device.

    Args:
        export: what is exported.
        tracks: of all listeners.
        device: its name in the format.
        name: of the pattern.
        modes: its modes of feedback, by the device's sides.
    """
    length = math.ceil(tracks.duration * 1000 / INTERVAL) * INTERVAL
    layouts = {
        position: [
            {"index": index, "x": round(x, 3), "y": round(y, 3)}
            for index, (x, y) in enumerate(places)
        ]
        for position, places in DEVICES[device].items()
    }
    return {
        "project": {
            "createdAt": 0,
            "updatedAt": 0,
            "name": name,
            "description": f"{export.name}, by {credit(export)}",
            "layout": {"name": device, "type": device, "layouts": layouts},
            "mediaFileDuration": math.ceil(tracks.duration),
            "tracks": [
                {
                    "enable": True,
                    "effects": [
                        {"name": export.name, "startTime": 0, "offsetTime": length, "modes": modes}
                    ],
                }
            ],
        },
        "durationMillis": length,
        "intervalMillis": INTERVAL,
        "size": 20,
    }


def read(path: Path) -> VibrationFile:
    """The vibrations of the body parts that the file addresses. Raises FormatError or OSError."""
    document = read_json(path)
    _convert_numbers(document)
    losses = {f"the format has no frequencies: motors are played at {FREQUENCY:g} Hz": None}
    without_damaged(document, _PARTS, losses, lambda: validate(document, _SCHEMA, path))
    project = document["project"]
    effects = [
        effect
        for track in project["tracks"]
        if track.get("enable", True)
        for effect in track["effects"]
    ]
    length = max((effect["startTime"] + effect["offsetTime"] for effect in effects), default=0)
    if length > LONGEST:
        raise FormatError(path, "/project/tracks", f"longer than {LONGEST // 1000} seconds")
    budget = Budget(path, is_json=True)
    steps = 0
    channels: list[KeyframedChannel] = []
    for position in dict.fromkeys(position for effect in effects for position in effect["modes"]):
        if position not in _LAYOUTS:
            losses[f"the position {position} is not known"] = None
            continue
        strengths = np.zeros((len(_LAYOUTS[position]), max(math.floor(length / INTERVAL) + 1, 0)))
        for effect in effects:
            if position in effect["modes"]:
                player = _Player(
                    strengths, _LAYOUTS[position], effect["startTime"], effect["offsetTime"]
                )
                player.play(effect["modes"][position])
                steps += player.steps
                if steps > MOST_STEPS:
                    raise FormatError(path, "/project/tracks", "too many effects at once")
        for channel in _channels(position, strengths, length / 1000):
            budget.take(sum(carrier.size for carrier in channel.carriers), "/project/tracks")
            channels.append(channel)
    order = {part.name: number for number, part in enumerate(BODY_PARTS)}
    return VibrationFile(
        tuple(sorted(channels, key=lambda channel: order[channel.name])), tuple(losses)
    )


def _convert_numbers(document: Any) -> None:
    """Convert the texts in the points of older files to numbers."""
    try:
        modes = [
            mode
            for track in document["project"]["tracks"]
            for effect in track["effects"]
            for mode in effect["modes"].values()
        ]
        for point in (
            point
            for mode in modes
            for key in _LISTS
            for feedback in mode[key]["feedback"]
            for point in feedback["pointList"]
        ):
            for key, value in point.items():
                if isinstance(value, str) and key in _NUMBERS and len(value) <= LONGEST_NUMBER:
                    number = _NUMBERS[key](value)
                    point[key] = number if math.isfinite(number) else value
    except (TypeError, KeyError, AttributeError, ValueError):
        pass  # not a valid file, as validation tells


class _Player:
    """Adds effects to a table of strengths (motors, steps), each of which is that at the beginning
    of its step, as the player samples them.

    start and length of the effect in milliseconds. ``steps``: number of steps played.
    """

    def __init__(
        self, table: FloatArray, places: Sequence[tuple[float, float]], start: float, length: float
    ) -> None:
        self._places, self._length = places, length
        bounds = math.ceil(start / INTERVAL), math.floor((start + length) / INTERVAL) + 1
        first, last = (min(max(step, 0), table.shape[1]) for step in bounds)
        self._played = table[:, first : max(first, last)]
        self._times = np.arange(first, max(first, last)) * INTERVAL - start
        self.steps = 0

    def play(self, mode: Form) -> None:
        """Add the mode that the effect uses."""
        if mode["mode"] == "PATH_MODE":
            for feedback in mode["pathMode"]["feedback"]:
                self._play_path(feedback)
        elif mode["dotMode"].get("dotConnected"):
            self._play_connected(mode["dotMode"]["feedback"])
        else:
            for feedback in mode["dotMode"]["feedback"]:
                dots = self._dots(feedback)
                fade = _FADES[feedback["playbackType"]]
                for here, share in self._between(
                    feedback["startTime"], feedback["endTime"], side="left"
                ):
                    self._add(here, np.outer(dots, fade(share)))

    def _dots(self, feedback: Form) -> FloatArray:
        """The strength of each motor in an interval; a motor that is named several times has the
        sum."""
        strengths = np.zeros(len(self._places))
        for point in feedback["pointList"]:
            if point["index"] < len(strengths):
                strengths[int(point["index"])] += point["intensity"]
        return strengths

    def _play_connected(self, feedback: Sequence[Form]) -> None:
        """Dots that blend: the strength of a motor is linear between the beginnings of the
        intervals, whose fades do not count."""
        intervals = sorted(feedback, key=lambda interval: interval["startTime"])
        for one, other in pairwise(intervals):
            before = self._dots(one)
            after = self._dots(other)
            for here, share in self._between(one["startTime"], other["startTime"]):
                self._add(here, np.outer(before, 1 - share) + np.outer(after, share))

    def _play_path(self, feedback: Form) -> None:
        """A point that moves between motors. A fade applies between every two points of the path; a
        single point stays for the whole effect."""
        points = sorted(feedback["pointList"], key=lambda point: point["time"])
        if len(points) == 1:
            points = [points[0] | {"time": 0.0}, points[0] | {"time": self._length}]
        for one, other in pairwise(points):
            for here, share in self._between(one["time"], other["time"]):
                x, y, strength = (
                    one[key] + share * (other[key] - one[key]) for key in ("x", "y", "intensity")
                )
                self._add(
                    here,
                    _weights(self._places, x, y)
                    * strength
                    * _FADES[feedback["playbackType"]](share),
                )

    def _between(
        self, start: float, end: float, side: Literal["left", "right"] = "right"
    ) -> Iterator[tuple[slice, FloatArray]]:
        """The steps that begin from ``start`` to ``end``, included where ``side`` is right, and the
        part of that time that has passed in them; a few thousand at a time."""
        first = np.searchsorted(self._times, start)
        last = np.searchsorted(self._times, end, side)
        for begin in range(first, last, _AT_ONCE):
            here = slice(begin, min(begin + _AT_ONCE, last))
            yield here, (self._times[here] - start) / max(end - start, 1e-9)

    def _add(self, here: slice, strengths: FloatArray) -> None:
        # The maker's program rounds what each dot and path adds down to whole percents.
        self._played[:, here] += np.floor(100 * strengths + _ROUNDING) / 100
        self.steps += strengths.shape[1]


def _weights(places: Sequence[tuple[float, float]], x: FloatArray, y: FloatArray) -> FloatArray:
    """The weights (motors, n) with which the motors at ``places`` play a point at ``x``, ``y``
    (n,), as in frames that the maker's program has written into files.

    It rounds positions down, first to tenths of the grid's cells, of which there are as many as
    motors, then to tenths of the distances of motors. The rectangles between neighbouring motors
    are cut into two triangles, from lower left to upper right. The corners of a point's triangle
    play it by its barycentric coordinates (a, b, c), each more than it: a + `MORE` bc / (b + c).
    """
    columns, rows = (np.unique([place[k] for place in places]) for k in (0, 1))
    across, down = (
        np.floor(np.floor(10 * n * values + _TINY) * (n - 1) / n + _TINY) / 10 + _TINY
        for values, n in ((x, len(columns)), (y, len(rows)))
    )
    # A motor's triangles form a hexagon, in which its coordinate falls linearly from 1 to 0.
    right = across - np.searchsorted(columns, [[place[0]] for place in places])
    below = down - np.searchsorted(rows, [[place[1]] for place in places])
    own = 1 - np.maximum(np.maximum(np.abs(right), np.abs(below)), np.abs(right + below))
    own = np.maximum(own, 0.0)
    others = np.maximum(1 - own, _TINY)
    products = (others**2 + own**2 - np.sum(own**2, axis=0)) / 2
    return np.where(own > 0, own + MORE * np.maximum(products, 0.0) / others, 0.0)


def _channels(position: str, table: FloatArray, duration: float) -> Iterator[KeyframedChannel]:
    """The vibrations of the body parts at a position, from the strengths of its motors (motors,
    steps)."""
    for part in BODY_PARTS:
        if (
            part.bhaptics != position or part.name == "head"
        ):  # the ears cover the motors of the head
            continue
        levels = np.clip(table[region(part, _LAYOUTS[position])].max(axis=0, initial=0.0), 0.0, 1.0)
        if levels.any():
            changed = np.flatnonzero(np.diff(levels)) + 1
            times = np.repeat(changed * (INTERVAL / 1000), 2)
            values = np.column_stack([levels[changed - 1], levels[changed]]).ravel()
            keys = np.concatenate([[0.0], times]), np.concatenate([levels[:1], values])
            carrier = Carrier(0.0, duration, 0.0, *keys, np.zeros(1), np.full(1, FREQUENCY))
            yield KeyframedChannel(part.name, duration, body_part=part.name, carriers=(carrier,))
