"""NPZ: the tracks as NumPy arrays."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...forms import Form
from ..io.atomic import atomic_file
from ..io.json_text import compact
from . import wav
from .comparison import Comparison
from .listener_tracks import CHUNK, Tracks
from .track_export import TrackExport, scene_file


def loss(export: TrackExport, options: Form) -> Iterator[str]:
    """What the file does not carry, one sentence each."""
    yield from wav.loss(export, {"encoding": "float32", "sample_rate": 0})


measures = wav.measures


def write(export: TrackExport, folder: Path, options: Form, measured: Comparison) -> list[Path]:
    """Write ``<scene>.npz``.

    Arrays: ``samples`` (n_listeners, n) of float32, ``sample_rate``, ``start``, ``names``,
    ``body_parts``, ``impacts`` (k, 3) of listener index, time and strength, and ``provenance``, a
    JSON text.
    """
    tracks = export.need_tracks()
    path = scene_file(export.name, folder, "npz")
    method = zipfile.ZIP_DEFLATED if options["compressed"] else zipfile.ZIP_STORED
    with atomic_file(path) as file, zipfile.ZipFile(file, "w", method) as archive:
        _write_samples(archive, tracks)
        for name, array in _small_arrays(export).items():
            with archive.open(f"{name}.npy", "w") as entry:
                np.lib.format.write_array(entry, array, allow_pickle=False)
    wav.compare_encoded("float32", measured)
    return [path]


def _small_arrays(export: TrackExport) -> dict[str, NDArray[Any]]:
    tracks = export.need_tracks()
    impacts = [
        np.insert(listener.impacts, 0, number, axis=1)
        for number, listener in enumerate(tracks.listeners)
    ]
    return {
        "sample_rate": np.array(tracks.sample_rate),
        "start": np.array(tracks.start),
        "names": np.array([listener.name for listener in tracks.listeners]),
        "body_parts": np.array([listener.body_part for listener in tracks.listeners]),
        "impacts": np.concatenate(impacts),
        "provenance": np.array(compact(dict(export.provenance))),
    }


def _write_samples(archive: zipfile.ZipFile, tracks: Tracks) -> None:
    shape = len(tracks.listeners), tracks.count
    with archive.open("samples.npy", "w", force_zip64=True) as entry:
        np.lib.format.write_array_header_1_0(
            entry, {"descr": "<f4", "fortran_order": False, "shape": shape}
        )
        for number in range(len(tracks.listeners)):
            for first in range(0, tracks.count, CHUNK):
                entry.write(
                    np.asarray(tracks.samples[number, first : first + CHUNK], dtype="<f4").tobytes()
                )
