"""``.tact`` (bHaptics): one file per device, with the strength of each of its motors in steps of 20 ms. Read as one vibration per body
part, the strongest of its motors."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import FloatArray, IntArray
from ...scene.bhaptics import DEVICES, region
from ...scene.body import BODY_PARTS
from ..io.atomic import write_text
from ..io.catalogue import FORMATS
from ..io.error import FormatError
from ..io.file_names import file_stems
from ..io.json_text import compact
from ..io.schema import validate
from ..io.strict_json import read_json
from .carrier import Carrier
from .comparison import Comparison, Kind, Measures
from .envelopes import coarse_envelope, compare_steps
from .listener_tracks import Tracks
from .track_export import TrackExport, body_part_of, common_losses
from .vibration_file import Channel, VibrationFile

INTERVAL = 20
"""Step of strengths (milliseconds)."""

FREQUENCY = 100.0
"""Frequency of the vibrations (hertz): the format has only strengths."""
STEP = 10
"""Step of the strengths that are read (milliseconds)."""
LONGEST = 3_600_000
"""Longest file (milliseconds)."""
MOST_STEPS = 5_000_000
"""Steps of all effects."""

LONGEST_NUMBER = 32
"""Characters of a number that is written as text."""

_FADES: Mapping[str, Callable[[FloatArray], FloatArray]] = {
    "FADE_IN": lambda share: share,
    "FADE_OUT": lambda share: 1 - share,
    "FADE_IN_OUT": lambda share: 1 - np.abs(2 * share - 1),
}
"""Amplitude by the part of an interval that has passed, both 0 to 1, for each fade; without a fade it is 1."""
_LISTS = ("dotMode", "pathMode")
_NUMBERS: Mapping[str, Callable[[str], float]] = {"index": int, "intensity": float, "x": float, "y": float, "time": float}
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


def loss(export: TrackExport, options: Mapping[str, Any]) -> Iterator[str]:
    """What the files do not carry, one sentence each."""
    tracks = export.need_tracks()
    driven = {number for indices in motors(tracks).values() for numbers in indices.values() for number in numbers}
    absent = [listener.name for number, listener in enumerate(tracks.listeners) if number not in driven]
    yield from common_losses(tracks, body=True)
    yield f"frequencies: the strength every {INTERVAL} ms remains, in {options['levels']} steps"
    if absent:
        yield f"listeners where no device is worn: {', '.join(absent)}"


def keeps(options: Mapping[str, Any]) -> Measures:
    """What the files keep."""
    return Measures(Kind.LEVEL)


def write(export: TrackExport, folder: Path, options: Mapping[str, Any], measured: Comparison) -> list[Path]:
    """Write ``<scene>.<device>.tact`` for each device that a listener wears."""
    tracks = export.need_tracks()
    driven = motors(tracks)
    devices = [device for device, layout in DEVICES.items() if any(position in driven for position in layout)]
    stems = file_stems(f"{export.name}.{device}" for device in devices)
    rows = [tracks.row(number) for number in range(len(tracks.listeners))]
    levels = np.array([coarse_envelope(row, INTERVAL / 1000)[0] for row in rows])
    steps = np.rint(np.clip(levels, 0.0, 1.0) * options["levels"]).astype(np.int64)
    shared = {number: numbers for indices in driven.values() for numbers in indices.values() for number in numbers}
    for number, row in enumerate(rows):
        played = steps[shared[number]].max(axis=0) if number in shared else np.zeros(steps.shape[1])
        compare_steps(row, number, played / options["levels"], INTERVAL / 1000, measured)
    files = []
    for device, stem in zip(devices, stems, strict=True):
        modes = {position: _mode(driven.get(position, {}), steps, options["levels"]) for position in DEVICES[device]}
        files.append(
            write_text(folder / f"{stem}{FORMATS['tact'].suffix}", [compact(_document(export, tracks, device, stem, modes)), "\n"])
        )
    return files


def _mode(indices: Mapping[int, list[int]], steps: IntArray, levels: int) -> dict[str, Any]:
    return {
        "mode": "DOT_MODE",
        "dotMode": {"dotConnected": False, "feedback": list(_feedback(indices, steps, levels))},
        "pathMode": {"feedback": [{"movingPattern": "CONST_TDM", "playbackType": "NONE", "visible": True, "pointList": []}]},
    }


def _feedback(indices: Mapping[int, list[int]], steps: IntArray, levels: int) -> Iterator[dict[str, Any]]:
    """Intervals in which no motor changes, except silent ones."""
    if not indices or not steps.shape[1]:
        return
    strengths = np.array([steps[numbers].max(axis=0) for numbers in indices.values()])
    changes = np.flatnonzero(np.append(True, np.any(np.diff(strengths, axis=1), axis=0)))
    for first, last in zip(changes.tolist(), np.append(changes[1:], strengths.shape[1]).tolist(), strict=True):
        points = [
            {"index": index, "intensity": round(strength / levels, 3)}
            for index, strength in zip(indices, strengths[:, first].tolist(), strict=True)
            if strength
        ]
        if points:
            yield {"startTime": first * INTERVAL, "endTime": last * INTERVAL, "playbackType": "NONE", "pointList": points}


def _document(export: TrackExport, tracks: Tracks, device: str, name: str, modes: dict[str, Any]) -> dict[str, Any]:
    length = math.ceil(tracks.duration * 1000 / INTERVAL) * INTERVAL
    layouts = {
        position: [{"index": index, "x": round(x, 3), "y": round(y, 3)} for index, (x, y) in enumerate(places)]
        for position, places in DEVICES[device].items()
    }
    return {
        "project": {
            "createdAt": 0,
            "updatedAt": 0,
            "name": name,
            "description": f"{export.name}, by Haptic Tracing",
            "layout": {"name": device, "type": device, "layouts": layouts},
            "mediaFileDuration": math.ceil(tracks.duration),
            "tracks": [{"enable": True, "effects": [{"name": export.name, "startTime": 0, "offsetTime": length, "modes": modes}]}],
        },
        "durationMillis": length,
        "intervalMillis": INTERVAL,
        "size": 20,
    }


def read(path: Path) -> VibrationFile:
    """The vibrations of the body parts that the file addresses. Raises FormatError or OSError."""
    document = read_json(path)
    _convert_numbers(document)
    validate(document, "tact", path)
    project = document["project"]
    losses = {f"the format has no frequencies: motors are played at {FREQUENCY:g} Hz": None}
    effects = [effect for track in project["tracks"] if track.get("enable", True) for effect in track["effects"]]
    length = max((effect["startTime"] + effect["offsetTime"] for effect in effects), default=0)
    if length > LONGEST:
        raise FormatError(path, "/project/tracks", f"longer than {LONGEST // 1000} seconds")
    strengths: dict[str, FloatArray] = {}
    steps = 0
    for effect in effects:
        for position, mode in effect["modes"].items():
            if position not in _LAYOUTS:
                losses[f"the position {position} is not known"] = None
                continue
            table = strengths.setdefault(position, np.zeros((len(_LAYOUTS[position]), max(-(-round(length) // STEP), 0))))
            player = _Player(table, _LAYOUTS[position], effect["startTime"], effect["offsetTime"])
            player.play(mode, losses)
            steps += player.steps
            if steps > MOST_STEPS:
                raise FormatError(path, "/project/tracks", "too many effects at once")
    return VibrationFile(tuple(_channels(strengths, length / 1000)), tuple(losses))


def _convert_numbers(document: Any) -> None:
    """Convert the texts in the points of older files to numbers."""
    try:
        modes = [mode for track in document["project"]["tracks"] for effect in track["effects"] for mode in effect["modes"].values()]
        for point in (point for mode in modes for key in _LISTS for feedback in mode[key]["feedback"] for point in feedback["pointList"]):
            for key, value in point.items():
                if isinstance(value, str) and key in _NUMBERS and len(value) <= LONGEST_NUMBER:
                    number = _NUMBERS[key](value)
                    point[key] = number if math.isfinite(number) else value
    except (TypeError, KeyError, AttributeError, ValueError):
        pass  # not a valid file, as validation tells


class _Player:
    """Enters an effect into a table of strengths (motors, steps): of simultaneous strengths the highest counts.

    start and length of the effect in milliseconds. ``steps``: number of steps entered.
    """

    def __init__(self, table: FloatArray, places: Sequence[tuple[float, float]], start: float, length: float) -> None:
        self._table, self._places, self._start, self._length = table, places, start, length
        self.steps = 0

    def play(self, mode: Mapping[str, Any], losses: dict[str, None]) -> None:
        """Enter the mode that the effect uses."""
        if mode["mode"] == "PATH_MODE":
            for feedback in mode["pathMode"]["feedback"]:
                if feedback["pointList"]:
                    self._play_path(feedback)
            return
        if mode["dotMode"].get("dotConnected"):
            losses["connected dots are played one by one"] = None
        for feedback in mode["dotMode"]["feedback"]:
            steps, shares = self._steps(feedback, feedback["startTime"], feedback["endTime"])
            for point in feedback["pointList"]:
                if point["index"] < len(self._places):
                    self._enter(point["index"], steps, shares * point["intensity"])

    def _play_path(self, feedback: Mapping[str, Any]) -> None:
        """A point that moves between motors: each plays it with a weight that falls linearly to 0 at the next column and row."""
        points = sorted(feedback["pointList"], key=lambda point: point["time"])
        times = [point["time"] for point in points]
        steps, shares = self._steps(feedback, times[0], times[-1])
        middles = (np.arange(steps.start, steps.stop) + 0.5) * STEP - self._start
        x, y, strength = (np.interp(middles, times, [point[key] for point in points]) for key in ("x", "y", "intensity"))
        columns, rows = (sorted({place[k] for place in self._places}) for k in (0, 1))
        for index, (column, row) in enumerate(self._places):
            weights = np.interp(x, columns, [float(knot == column) for knot in columns])
            weights *= np.interp(y, rows, [float(knot == row) for knot in rows])
            self._enter(index, steps, weights * strength * shares)

    def _steps(self, feedback: Mapping[str, Any], start: float, end: float) -> tuple[slice, FloatArray]:
        """The steps of an interval (milliseconds from the effect's start), and the share of the strength in each."""
        begin, until = (self._start + min(max(time, 0.0), self._length) for time in (start, end))
        count = self._table.shape[1]
        first, last = min(max(round(begin / STEP), 0), count), min(max(round(until / STEP), 0), count)
        last = max(first, last)
        self.steps += last - first
        share = (np.arange(first, last) + 0.5 - first) / max(last - first, 1)
        return slice(first, last), _FADES.get(feedback.get("playbackType", ""), np.ones_like)(share)

    def _enter(self, index: int, steps: slice, strengths: FloatArray) -> None:
        np.maximum(self._table[index, steps], strengths, out=self._table[index, steps])


def _channels(strengths: Mapping[str, FloatArray], duration: float) -> Iterator[Channel]:
    for part in BODY_PARTS:
        if part.bhaptics is None or part.bhaptics not in strengths or part.name == "head":  # the ears cover the motors of the head
            continue
        table = strengths[part.bhaptics]
        levels = np.clip(table[region(part, _LAYOUTS[part.bhaptics])].max(axis=0, initial=0.0), 0.0, 1.0)
        if levels.any():
            changed = np.flatnonzero(np.diff(levels)) + 1
            times = np.repeat(changed * (STEP / 1000), 2)
            values = np.column_stack([levels[changed - 1], levels[changed]]).ravel()
            keys = np.concatenate([[0.0], times]), np.concatenate([levels[:1], values])
            carrier = Carrier(0.0, duration, 0.0, *keys, np.zeros(1), np.full(1, FREQUENCY))
            yield Channel(part.name, duration, (carrier,), body_part=part.name)
