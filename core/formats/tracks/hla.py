"""HLA (Hapticlabs, Android): one file per listener with stepped amplitudes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...forms import Form
from ..io.json_text import write_compact
from .comparison import Comparison, Kind, Measures
from .envelopes import compare_steps, vibration_envelope
from .track_export import TrackExport, common_losses, listener_files


def loss(export: TrackExport, options: Form) -> Iterator[str]:
    """What the files do not carry, one sentence each."""
    yield from common_losses(export.need_tracks(), body=False)
    yield "the place on the body: a phone has one actuator; the file name gives the listener"
    yield f"frequencies: the strength every {options['step']} ms remains, in 255 steps"
    yield "impacts between two steps"


def measures(options: Form) -> Measures:
    """How the files can be compared with the tracks."""
    return Measures(Kind.LEVEL)


def write(export: TrackExport, folder: Path, options: Form, measured: Comparison) -> list[Path]:
    """Write ``<scene>.<listener>.hla``."""
    step = options["step"] / 1000
    files = []
    for number, listener, row, path in listener_files(export, folder, "hla"):
        amplitude, _ = vibration_envelope(row, step)
        levels = np.rint(np.clip(amplitude, 0.0, 1.0) * 255).astype(np.int64)
        compare_steps(number, levels / 255, step, measured)
        first = np.flatnonzero(np.diff(levels, prepend=-1))
        lengths = np.diff(first, append=len(levels)) * options["step"]
        document = {
            "ProjectName": export.name,
            "TrackName": listener.name,
            "Duration": int(lengths.sum()),
            "Timings": lengths.tolist(),
            "Amplitudes": levels[first].tolist(),
            "Repeat": -1,
            "RequiredAudioFiles": [],
            "Audios": [],
        }
        files.append(write_compact(path, document))
    return files
