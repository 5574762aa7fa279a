"""OHM: the description of a WAV file's channels for the reference encoder of MPEG haptics, written
with the WAV file."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path

from ...forms import Form
from ..io.atomic import write_bytes
from . import wav
from .comparison import Comparison
from .listener_tracks import ListenerTrack
from .track_export import TrackExport, body_part_of, credit, scene_file

_ENCODING = "pcm16"


def loss(export: TrackExport, options: Form) -> Iterator[str]:
    """What the files do not carry, one sentence each."""
    long = [
        listener.name
        for listener in export.need_tracks().listeners
        if len(listener.name.encode()) > 32
    ]
    yield from wav.loss(export, {"encoding": _ENCODING, "sample_rate": 0})
    if long:
        yield f"names beyond 32 bytes: {', '.join(long)}"


measures = wav.measures


def write(export: TrackExport, folder: Path, options: Form, measured: Comparison) -> list[Path]:
    """Write ``<scene>.ohm`` and ``<scene>.wav``."""
    tracks = export.need_tracks()
    path = scene_file(export.name, folder, "ohm")
    recording = scene_file(export.name, folder, "wav")
    if len(tracks.listeners) > 32767 or len(recording.name.encode()) > 64:
        raise ValueError(f"{path}: more listeners, or a longer name, than an OHM file can hold")
    wav.write_wav(tracks, recording, _ENCODING, credit(export))
    wav.compare_encoded(_ENCODING, measured)
    head = b"OHM " + struct.pack(">hh", 1, 1) + _text(export.name, 32)
    element = (
        _text(recording.name, 64)
        + _text(export.name, 32)
        + struct.pack(">h", len(tracks.listeners))
    )
    write_bytes(path, head + element + b"".join(_channels(tracks.listeners)))
    return [recording, path]


def _channels(listeners: tuple[ListenerTrack, ...]) -> Iterator[bytes]:
    for listener in listeners:
        part = body_part_of(listener)
        # The gain is little-endian, unlike everything else, because the reference software reads it
        # so.
        yield (
            _text(listener.name, 32)
            + struct.pack("<f", 1.0)
            + struct.pack(">I", 0 if part is None else part.mpeg_mask)
        )


def _text(text: str, size: int) -> bytes:
    """UTF-8 cut to ``size`` bytes at a character boundary and padded with zeros."""
    return text.encode()[:size].decode(errors="ignore").encode().ljust(size, b"\0")
