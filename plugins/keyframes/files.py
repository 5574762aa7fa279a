"""Files of keyframes: their names, points in JSON, and JSON with trailing commas."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from ...core.arrays import FloatArray
from ...core.formats.io.file_names import file_stems
from ...core.formats.tracks.listener_tracks import ListenerTrack, Row
from ...core.formats.tracks.track_export import TrackExport
from ...core.forms import JsonObject

_TRAILING = re.compile(rb'"(?:[^"\\]++|\\.)*+"|,(?=[ \t\r\n]*[]}])', re.DOTALL)
"""A string, or a comma outside of strings before a closing bracket."""


def listener_files(
    export: TrackExport, folder: Path, suffix: str
) -> Iterator[tuple[int, ListenerTrack, Row, Path]]:
    """Number, name and samples of each listener, and the path of its file:
    ``<scene>.<listener><suffix>``, or ``<scene><suffix>`` for the only one."""
    tracks = export.need_tracks()
    names = (
        [export.name]
        if len(tracks.listeners) == 1
        else [f"{export.name}.{listener.name}" for listener in tracks.listeners]
    )
    for number, (listener, stem) in enumerate(
        zip(tracks.listeners, file_stems(names), strict=True)
    ):
        yield number, listener, tracks.row(number), folder / f"{stem}{suffix}"


def json_points(
    first_key: str, second_key: str, first: FloatArray, second: FloatArray
) -> list[JsonObject]:
    """Objects with the same two keys, from a column (n,) of numbers for each."""
    return [
        {first_key: x, second_key: y} for x, y in zip(first.tolist(), second.tolist(), strict=True)
    ]


def without_trailing_commas(data: bytes) -> bytes:
    """JSON text with a space in place of each comma before a closing bracket, which some
    applications accept."""
    return _TRAILING.sub(lambda found: b" " if found[0] == b"," else found[0], data)
