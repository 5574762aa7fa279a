"""Android's waveform as JSON: the arguments of ``VibrationEffect.createWaveform``, ``timings`` in
milliseconds and ``amplitudes`` from 0 to 255, one file per listener.

The actuator vibrates at its own frequency. Equal amplitudes in succession are one.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...core.formats.io.json_text import write_compact
from ...core.formats.tracks.fidelity import Progress
from ...core.formats.tracks.listener_tracks import Tracks
from ...core.formats.tracks.track_export import TrackExport, common_losses, credit
from ...core.forms import Form
from ..keyframes.comparison import Comparison, Kind, Measures
from ..keyframes.envelopes import compare_steps, vibration_envelope
from ..keyframes.files import listener_files

LARGEST = 255
"""The amplitude of full strength."""


def loss(export: TrackExport, options: Form) -> Iterator[str]:
    """What the files do not carry, one sentence each."""
    yield from common_losses(export.need_tracks(), body=False)
    yield "the place on the body: a phone has one actuator; the file name gives the listener"
    yield f"frequencies: the strength every {options['milliseconds']} ms remains, in 255 steps"
    yield "impacts between two steps"


def comparison(tracks: Tracks, options: Form, progress: Progress) -> Comparison:
    """What compares the files with the tracks."""
    return Comparison(tracks, Measures(Kind.LEVEL), progress)


def write(export: TrackExport, folder: Path, options: Form, measured: Comparison) -> list[Path]:
    """Write ``<scene>.<listener>.waveform``."""
    milliseconds = options["milliseconds"]
    files = []
    for number, listener, row, path in listener_files(export, folder, ".waveform"):
        strength, _ = vibration_envelope(row, milliseconds / 1000)
        levels = np.rint(np.clip(strength, 0.0, 1.0) * LARGEST).astype(np.int64)
        compare_steps(number, levels / LARGEST, milliseconds / 1000, measured)
        first = np.flatnonzero(np.diff(levels, prepend=-1))
        document = {
            "name": listener.name,
            "generator": credit(export),
            "timings": (np.diff(first, append=len(levels)) * milliseconds).tolist(),
            "amplitudes": levels[first].tolist(),
            "repeat": -1,
        }
        files.append(write_compact(path, document))
    return files
