"""``.tact`` (bHaptics): a file per device, with the strength of each of its motors in steps of 20 ms."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import IntArray
from ..io.atomic import write_text
from ..io.catalogue import FORMATS
from ..io.file_names import file_stems
from ..io.json_text import compact
from .envelopes import coarse_envelope
from .listener_tracks import Tracks
from .track_export import TrackExport, body_part_of, clipped, common_losses

SUFFIX = FORMATS["tact"].suffix

INTERVAL = 20
"""Milliseconds."""

# The motors' places, x from the wearer's left to right (also on the back), y downwards; as in the maker's own files.
_VEST = tuple((i % 4 / 3, i // 4 / 4) for i in range(20))
_HEAD = tuple((i / 5, 0.5) for i in range(6))
_ARM = tuple((i % 3 / 2, float(i // 3)) for i in range(6))
_HAND = tuple((0.5, i / 2) for i in range(3))
_FOOT = tuple((i / 2, 0.5) for i in range(3))
DEVICES: dict[str, dict[str, tuple[tuple[float, float], ...]]] = {
    "Tactot": {"VestFront": _VEST, "VestBack": _VEST},
    "Tactal": {"Head": _HEAD},
    "Tactosy2": {"ForearmL": _ARM, "ForearmR": _ARM},
    "Hand": {"HandL": _HAND, "HandR": _HAND},
    "Foot": {"FootL": _FOOT, "FootR": _FOOT},
}
"""Motors (x, y) of each position, by device."""

_HALVES = {"L": (0.0, 0.5), "R": (0.5, 1.0), "": (0.0, 1.0)}
_HEIGHTS = {"upper_back": (0.0, 0.4), "middle_back": (0.4, 1.0), "chest": (0.0, 0.6), "belly": (0.6, 1.0)}


def motors(tracks: Tracks) -> dict[str, dict[int, list[int]]]:
    """For each position, which listeners (numbers) each motor stands for."""
    layouts = {position: places for layout in DEVICES.values() for position, places in layout.items()}
    result: dict[str, dict[int, list[int]]] = {}
    for number, listener in enumerate(tracks.listeners):
        part = body_part_of(listener)
        if part is None or part.bhaptics not in layouts:
            continue
        across = _HALVES[part.side] if part.bhaptics.startswith("Vest") or part.bhaptics == "Head" else (0.0, 1.0)
        along = _HEIGHTS.get(part.name.partition(".")[0], (0.0, 1.0))
        for index, (x, y) in enumerate(layouts[part.bhaptics]):
            if across[0] <= x <= across[1] and along[0] <= y <= along[1]:
                result.setdefault(part.bhaptics, {}).setdefault(index, []).append(number)
    return result


def loss(export: TrackExport, options: Mapping[str, Any]) -> tuple[str, ...]:
    """What the files leave out, in words."""
    tracks = export.need_tracks()
    driven = {number for indices in motors(tracks).values() for numbers in indices.values() for number in numbers}
    unheard = [listener.name for number, listener in enumerate(tracks.listeners) if number not in driven]
    return (
        *common_losses(tracks, body=True),
        f"frequencies: the strength every {INTERVAL} ms remains, in {options['levels']} steps",
        *([f"listeners where no device is worn: {', '.join(unheard)}"] if unheard else []),
    )


def write(export: TrackExport, folder: Path, options: Mapping[str, Any]) -> list[Path]:
    """Write ``<scene>.<device>.tact`` for each device that a listener wears."""
    tracks = export.need_tracks()
    driven = motors(tracks)
    devices = [device for device, layout in DEVICES.items() if any(position in driven for position in layout)]
    stems = file_stems(f"{export.name}.{device}" for device in devices)
    levels = [coarse_envelope(clipped(samples), tracks.sample_rate, INTERVAL / 1000)[0] for samples in tracks.samples]
    steps = np.rint(np.clip(np.array(levels), 0.0, 1.0) * options["levels"]).astype(np.int64)
    files = []
    for device, stem in zip(devices, stems, strict=True):
        modes = {position: _mode(driven.get(position, {}), steps, options["levels"]) for position in DEVICES[device]}
        files.append(write_text(folder / f"{stem}{SUFFIX}", [compact(_document(export, tracks, device, stem, modes)), "\n"]))
    return files


def _mode(indices: Mapping[int, list[int]], steps: IntArray, levels: int) -> dict[str, Any]:
    return {
        "mode": "DOT_MODE",
        "dotMode": {"dotConnected": False, "feedback": list(_feedback(indices, steps, levels))},
        "pathMode": {"feedback": [{"movingPattern": "CONST_TDM", "playbackType": "NONE", "visible": True, "pointList": []}]},
    }


def _feedback(indices: Mapping[int, list[int]], steps: IntArray, levels: int) -> Iterator[dict[str, Any]]:
    """Stretches of time in which no motor changes, the silent ones left out."""
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
