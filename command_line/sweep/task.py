"""One variant of a study, traced in its own process: ``python -m
haptic_tracing.command_line.sweep.task``.

The task is one line of JSON on standard input, which stays open: when it closes, the parent process
has died, and this process ends as well.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
from bpy.types import Scene

from ...addon.authoring import materials as library
from ...addon.io.capture import Capture
from ...addon.session import timeline
from ...core.formats import registry
from ...core.formats.export import Export
from ...core.formats.io.atomic import write_bytes
from ...core.formats.tracks.listener_tracks import Tracks
from ...core.formats.tracks.track_recorder import TrackRecorder
from ...core.forms import Form, JsonObject
from ...core.perception import threshold_level
from ...core.render.frame_result import FrameResult
from ...core.render.levels import vibration_rms
from ...core.scene.materials import MATERIALS
from ...core.scene.values import SourceKind
from .. import one_line, temporary_folder
from ..part_file import checksum_of
from ..setting import assign
from ..trace import open_file, start_blender

_TACTILE = np.arange(5.0, 1001.0)
"""Frequencies that can be felt [Hz]."""


def main() -> int:
    """Trace the task on standard input. Exit code 0; 2 with the reason on stderr if it cannot be
    traced."""
    task = json.loads(sys.stdin.readline())
    threading.Thread(target=_end_with_the_asker, daemon=True).start()
    try:
        start_blender()
        _trace(task)
    except (ValueError, OSError) as error:
        print(one_line(str(error)), file=sys.stderr)
        return 2
    return 0


def _end_with_the_asker() -> None:
    sys.stdin.read()
    temporary_folder.remove()
    os._exit(1)


def vary(scene: Scene, variant: Form) -> None:
    """Apply the mode, materials and settings of a variant to the open scene. Raises ValueError,
    which names the value that cannot be set."""
    if variant["mode"] is not None:
        scene.haptics.mode = variant["mode"]
    for name, material in variant["materials"].items():
        obj = scene.objects.get(name)
        if obj is None or not obj.is_editable:
            raise ValueError(f"materials: there is no object '{name}' that can be edited")
        library.apply([obj], library.preset_in(scene, MATERIALS[material]))
    for path, value in variant["settings"].items():
        try:
            assign(scene, f"{path}={value}")
        except ValueError as error:
            raise ValueError(str(error).removeprefix("--set ")) from None


def frames_of(scene: Scene, variant: Form) -> tuple[int, int]:
    """First and last frame of a variant of the open scene."""
    first, last = variant["frames"] or (scene.frame_start, scene.frame_end)
    return first, last


def _trace(task: Form) -> None:
    """Trace a variant; write its tracks if requested, then its result."""
    variant, folder, key = task["variant"], Path(task["folder"]), task["key"]
    if checksum_of(Path(variant["scene"])) != variant["blend"]:
        raise ValueError(f"{variant['scene']}: has changed since the study began")
    scene = open_file(variant["scene"])
    vary(scene, variant)
    recorder, felt, origin = TrackRecorder(), _VariantGains(), None
    first, last = frames_of(scene, variant)
    for step in timeline.steps(scene, first, last + 1):
        if origin is None:
            origin = Capture.of(scene, step.result).provenance
        recorder.add(step.result)
        if step.result.number <= last:
            felt.add(step.result, step.tracing_milliseconds)
    tracks = recorder.tracks()
    if task["tracks"] and tracks.listeners:
        registry.write(
            "wav",
            Export(key, tracks=tracks, origin=origin),
            folder / "tracks",
            {"encoding": "float32"},
        )
    write_bytes(
        folder / "results" / f"{key}.json",
        json.dumps(felt.result(tracks), allow_nan=False).encode(),
    )


class _VariantGains:
    """Gains over the frames of a variant, and which listeners its settings silence."""

    def __init__(self) -> None:
        self._gains: JsonObject = defaultdict(float)
        self._silenced: Any = False
        self._milliseconds: list[float] = []

    def add(self, result: FrameResult, milliseconds: float) -> None:
        """Add a frame that took ``milliseconds`` to trace."""
        self._milliseconds.append(milliseconds)
        found = result.propagation
        self._silenced = self._silenced | np.array([item.gain == 0 for item in result.listeners])
        for row, source in enumerate(result.sources):
            if source.kind is SourceKind.PERSISTENT:
                self._gains[source.name] = self._gains[source.name] + result.amplitudes[row]
            if source.amplitude > 0:
                self._silenced = self._silenced | found.silenced[row]

    def result(self, tracks: Tracks) -> JsonObject:
        """The median time of a frame; per listener RMS (without its steady part) and peak of its
        samples, impacts, mean gains of persistent sources (amplitudes included), whether a setting
        silences the listener, at least for some source in some frame, and the lowest threshold of
        feeling [dB of full scale] by the calibration of its device, None without one."""
        count = len(self._milliseconds)
        silenced = np.broadcast_to(self._silenced, len(tracks.listeners))
        return {
            "milliseconds": float(np.median(self._milliseconds)),
            "frames": count,
            "listeners": [
                {
                    "listener": item.name,
                    "body_part": item.body_part,
                    "rms": float(vibration_rms(tracks.samples[row], tracks.sample_rate)),
                    "peak": float(np.abs(tracks.samples[row]).max(initial=0.0)),
                    "impacts": len(item.impacts),
                    "gains": {
                        name: float(total[row]) / count
                        for name, total in sorted(self._gains.items())
                    },
                    "silenced": bool(silenced[row]),
                    "threshold": item.device
                    and float(threshold_level(_TACTILE, item.device).min()),
                }
                for row, item in enumerate(tracks.listeners)
            ],
        }


if __name__ == "__main__":
    sys.exit(main())
