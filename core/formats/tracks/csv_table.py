"""CSV: one line per sample with the time and the value of each listener."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...forms import Form
from ..io.atomic import atomic_file
from . import wav
from .comparison import Comparison
from .listener_tracks import Tracks
from .track_export import TrackExport, common_losses, scene_file

_WIDTH = 8
_LINES = 2**15
_AT_ONCE = 2**10
"""Lines whose text stays in the processor's cache while it is made."""


def loss(export: TrackExport, options: Form) -> Iterator[str]:
    """What the file does not carry, one sentence each."""
    yield from common_losses(export.need_tracks(), body=False)
    yield wav.ROUNDING
    yield "impacts as such"


measures = wav.measures


def write(export: TrackExport, folder: Path, options: Form, measured: Comparison) -> list[Path]:
    """Write ``<scene>.csv``: seconds with six decimals, values with five."""
    tracks = export.need_tracks()
    path = scene_file(export.name, folder, "csv")
    head = io.StringIO()
    csv.writer(head, lineterminator="\n").writerow(
        ["time", *(listener.name for listener in tracks.listeners)]
    )
    with atomic_file(path) as file:
        file.write(head.getvalue().encode())
        first = 0
        for block in wav.encoded(tracks, "pcm16"):
            for begin in range(0, block.shape[1], _LINES):
                file.writelines(_lines(tracks, first + begin, block[:, begin : begin + _LINES]))
            first += block.shape[1]
    wav.compare_encoded("pcm16", measured)
    return [path]


def _lines(tracks: Tracks, first: int, block: NDArray[np.int16]) -> Iterator[memoryview]:
    """Lines of equal width: the text of every 16 bit value is looked up."""
    listeners, lines = block.shape
    step = 1e6 / tracks.sample_rate
    digits = max(len(str(round((first + lines - 1) * step))), 7)
    places = 10 ** np.arange(digits - 1, -1, -1)
    for begin in range(0, lines, _AT_ONCE):
        values = block[:, begin : begin + _AT_ONCE].T
        count = len(values)
        microseconds = np.rint(np.arange(first + begin, first + begin + count) * step).astype(
            np.int64
        )
        times = microseconds[:, None] // places % 10 + ord("0")
        text = np.empty((count, digits + 1 + listeners * (1 + _WIDTH) + 1), dtype=np.uint8)
        text[:, : digits - 6] = times[:, :-6]
        text[:, digits - 6] = ord(".")
        text[:, digits - 5 : digits + 1] = times[:, -6:]
        cells = text[:, digits + 1 : -1].reshape(count, listeners, 1 + _WIDTH)
        cells[:, :, 0] = ord(",")
        cells[:, :, 1:] = (
            _texts()[values.astype(np.int64, order="C") + 32768]
            .view(np.uint8)
            .reshape(count, listeners, _WIDTH)
        )
        text[:, -1] = ord("\n")
        yield text.data


@cache
def _texts() -> NDArray[np.uint64]:
    """The text of each 16 bit value: ``_WIDTH`` characters, as one number."""
    text = "".join(f"{value / 32768:{_WIDTH}.5f}" for value in range(-32768, 32768))
    return np.frombuffer(text.encode(), dtype=np.uint64)
