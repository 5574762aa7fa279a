"""``.tact`` (bHaptics): one file per device, with the strength of each of its motors in steps of 20 ms."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import IntArray
from ...scene.bhaptics import DEVICES, region
from ..io.atomic import write_text
from ..io.catalogue import FORMATS
from ..io.file_names import file_stems
from ..io.json_text import compact
from .comparison import Comparison, Kind, Measures
from .envelopes import coarse_envelope, compare_steps
from .listener_tracks import Tracks
from .tact_reading import read as read
from .track_export import TrackExport, body_part_of, common_losses

INTERVAL = 20
"""Step of strengths (milliseconds)."""


def motors(tracks: Tracks) -> dict[str, dict[int, list[int]]]:
    """For each position and motor index, the numbers of the listeners that it represents."""
    layouts = {position: places for layout in DEVICES.values() for position, places in layout.items()}
    result: dict[str, dict[int, list[int]]] = {}
    for number, listener in enumerate(tracks.listeners):
        part = body_part_of(listener)
        if part is not None and part.bhaptics in layouts:
            for index in region(part, layouts[part.bhaptics]):
                result.setdefault(part.bhaptics, {}).setdefault(index, []).append(number)
    return result


def loss(export: TrackExport, options: Mapping[str, Any]) -> tuple[str, ...]:
    """What the files do not carry, one sentence each."""
    tracks = export.need_tracks()
    driven = {number for indices in motors(tracks).values() for numbers in indices.values() for number in numbers}
    absent = [listener.name for number, listener in enumerate(tracks.listeners) if number not in driven]
    return (
        *common_losses(tracks, body=True),
        f"frequencies: the strength every {INTERVAL} ms remains, in {options['levels']} steps",
        *([f"listeners where no device is worn: {', '.join(absent)}"] if absent else []),
    )


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
