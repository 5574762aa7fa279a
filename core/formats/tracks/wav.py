"""WAV: a channel per listener (WAVE_FORMAT_EXTENSIBLE), with a side-car that says whose each is."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ...signals.interpolation import resample
from ...signals.wav import wav_channels
from ..io.atomic import atomic_file
from ..io.catalogue import FORMATS
from ..io.error import FormatError
from ..io.json_text import write_json
from ..io.strict_json import read_bytes, read_json
from .listener_tracks import ListenerTrack, Tracks
from .track_export import TrackExport, body_part_of, common_losses, scene_file
from .vibration_file import Channel, VibrationFile

SUFFIX = FORMATS["wav"].suffix
SIDECAR_SUFFIX = ".wav.json"

_REST_OF_GUID = bytes.fromhex("000000001000800000aa00389b71")
_CODES = {"pcm16": 1, "float32": 3}
_BYTES = {"pcm16": 2, "float32": 4}
MAX_RIFF = 2**32 - 1


def loss(export: TrackExport, options: Mapping[str, Any]) -> tuple[str, ...]:
    """What the files leave out, in words."""
    tracks = export.need_tracks()
    sampled = options["sample_rate"] and options["sample_rate"] < tracks.sample_rate
    losses = [text for text in common_losses(tracks, body=False) if options["encoding"] == "pcm16" or "full scale" not in text]
    return (
        *losses,
        *(["what lies below 1/65,536 of full scale"] if options["encoding"] == "pcm16" else []),
        *([f"what lies above {options['sample_rate'] / 2:g} Hz"] if sampled else []),
    )


def write(export: TrackExport, folder: Path, options: Mapping[str, Any]) -> list[Path]:
    """Write ``<scene>.wav`` and ``<scene>.wav.json``."""
    tracks = at_rate(export.need_tracks(), options["sample_rate"])
    path = scene_file(export.name, folder, SUFFIX)
    write_wav(tracks, path, options["encoding"])
    sidecar = path.with_name(path.name.removesuffix(SUFFIX) + SIDECAR_SUFFIX)
    return [path, write_json(sidecar, {"format": "haptic-tracks", "version": "1.0", "file": path.name, **described(tracks)})]


def described(tracks: Tracks) -> dict[str, Any]:
    """Whose each channel is and what happens when, as JSON."""
    return {
        "sample_rate": tracks.sample_rate,
        "samples": tracks.count,
        "start": tracks.start,
        "listeners": [
            {
                "name": listener.name,
                "body_part": listener.body_part,
                **_mpeg(listener),
                "impacts": listener.impacts.tolist(),
            }
            for listener in tracks.listeners
        ],
    }


def _mpeg(listener: ListenerTrack) -> dict[str, Any]:
    part = body_part_of(listener)
    return {} if part is None else {"mpeg_mask": part.mpeg_mask, "mpeg_target": list(part.mpeg_target)}


def at_rate(tracks: Tracks, sample_rate: int) -> Tracks:
    """The tracks at another rate; 0: as they are."""
    if sample_rate in (0, tracks.sample_rate):
        return tracks
    samples = np.array([resample(row.astype(np.float64), tracks.sample_rate, sample_rate) for row in tracks.samples], dtype=np.float32)
    return Tracks(tracks.listeners, sample_rate, samples, tracks.start)


def write_wav(tracks: Tracks, path: Path, encoding: str = "pcm16") -> None:
    """Write the samples as ``pcm16`` or ``float32``, a piece at a time. Raises ValueError where a WAV file can't hold them."""
    channels, width = len(tracks.listeners), _BYTES[encoding]
    size = channels * tracks.count * width
    header = _header(channels, tracks.sample_rate, width, _CODES[encoding], tracks.count, size)
    if channels > 65535 // width or len(header) + size - 8 > MAX_RIFF:
        raise ValueError(f"{path}: {channels} listeners and {tracks.duration:g} s are more than a WAV file can hold")
    with atomic_file(path) as file:
        file.write(header)
        _write_samples(file, tracks, encoding)


def _header(channels: int, rate: int, width: int, code: int, count: int, size: int) -> bytes:
    form = struct.pack("<HHIIHHHHIH", 0xFFFE, channels, rate, rate * channels * width, channels * width, 8 * width, 22, 8 * width, 0, code)
    form += _REST_OF_GUID
    fact = b"fact" + struct.pack("<II", 4, count) if code == 3 else b""
    chunks = b"WAVE" + b"fmt " + struct.pack("<I", len(form)) + form + fact + b"data" + struct.pack("<I", size & MAX_RIFF)
    return b"RIFF" + struct.pack("<I", (len(chunks) + size) & MAX_RIFF) + chunks


def _write_samples(file: BinaryIO, tracks: Tracks, encoding: str) -> None:
    for block in encoded(tracks, encoding):
        file.write(np.ascontiguousarray(block.T).tobytes())


def encoded(tracks: Tracks, encoding: str) -> Iterator[NDArray[Any]]:
    """The samples in pieces, as 16 bit of which 32,768 is full scale, or as float; little-endian."""
    for _, block in tracks.blocks():
        if encoding == "pcm16":
            yield np.clip(np.rint(block * 32768.0), -32768, 32767).astype("<i2")
        else:
            yield block.astype("<f4")


def read(path: Path) -> VibrationFile:
    """The channels, named by the side-car where there is one. Raises FormatError or OSError."""
    try:
        samples, rate = wav_channels(read_bytes(path, MAX_RIFF))
        if not np.isfinite(samples).all():
            raise ValueError("has samples that are not finite")
    except ValueError as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError(path, "/", str(error)) from None
    named = _named(path, samples.shape[1])
    return VibrationFile(
        tuple(
            Channel(name, len(samples) / rate, samples=np.ascontiguousarray(column), sample_rate=rate, body_part=body_part)
            for (name, body_part), column in zip(named, samples.T, strict=True)
        )
    )


def _named(path: Path, count: int) -> list[tuple[str, str]]:
    """Name and body part of each channel: from the side-car if it is one of ours and fits."""
    try:
        listeners = read_json(path.with_name(path.name + ".json"))["listeners"]
        named = [(str(form["name"]), str(form["body_part"])) for form in listeners]
    except (OSError, FormatError, TypeError, KeyError):
        named = []
    if len(named) == count:
        return named
    return [(path.stem if count == 1 else f"{path.stem} {number}", "") for number in range(1, count + 1)]
