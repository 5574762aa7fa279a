"""WAV: one channel per listener (WAVE_FORMAT_EXTENSIBLE), with a side-car that names the
listeners."""

from __future__ import annotations

import struct
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ...declaration import declared
from ...forms import Form, JsonObject
from ...perception import FullScale
from ...regular_file import open_regular
from ...scene.values import Listener
from ...signals.interpolation import resample
from ...signals.limits import MAX_PEAK
from ...signals.wav import WavFile
from ..io.atomic import atomic_file
from ..io.error import FormatError
from ..io.json_text import write_json
from ..io.strict_json import read_json
from .fidelity import Progress, SampleComparison
from .listener_tracks import CHUNK, ListenerTrack, Tracks
from .track_export import TrackExport, body_part_of, common_losses, credit, scene_file
from .vibration_file import Channel, VibrationFile

SIDECAR_SUFFIX = ".wav.json"
ROUNDING = "what lies below 1/65,536 of full scale"

_REST_OF_GUID = bytes.fromhex("000000001000800000aa00389b71")
_CODES = {"pcm16": 1, "float32": 3}
TYPES = {"pcm16": "<i2", "float32": "<f4"}
FULL_SCALE = {"pcm16": 32768.0, "float32": 1.0}
MAX_SAMPLE = MAX_PEAK / 4
"""Largest magnitude of samples that are read; larger ones may overflow in interpolation."""
MAX_RIFF = 2**32 - 1


def loss(export: TrackExport, options: Form) -> Iterator[str]:
    """What the files do not carry, one sentence each."""
    tracks = export.need_tracks()
    is_rounded = options["encoding"] == "pcm16"
    yield from (
        text for text in common_losses(tracks, body=False) if is_rounded or "full scale" not in text
    )
    if is_rounded:
        yield ROUNDING
    if options["sample_rate"] and options["sample_rate"] < tracks.sample_rate:
        yield f"what lies above {options['sample_rate'] / 2:g} Hz"


def comparison(tracks: Tracks, options: Form, progress: Progress) -> SampleComparison:
    """What compares the files with the tracks."""
    return SampleComparison(tracks, progress)


def write(
    export: TrackExport, folder: Path, options: Form, measured: SampleComparison
) -> list[Path]:
    """Write ``<scene>.wav`` and ``<scene>.wav.json``."""
    original = export.need_tracks()
    tracks = at_rate(original, options["sample_rate"])
    path = scene_file(export.name, folder, ".wav")
    write_wav(tracks, path, options["encoding"], credit(export))
    if tracks is original:
        compare_encoded(options["encoding"], measured)
    else:
        again = at_rate(tracks, original.sample_rate)
        for number, samples in enumerate(again.samples):
            measured.add(number, np.asarray(samples[: original.count], dtype=np.float64))
    sidecar = path.with_suffix(SIDECAR_SUFFIX)
    return [
        path,
        write_json(
            sidecar,
            {
                "format": "haptic-tracks",
                "version": "1.0",
                "file": path.name,
                "provenance": dict(export.provenance),
                **described(tracks),
            },
        ),
    ]


def described(tracks: Tracks) -> JsonObject:
    """The JSON description of tracks: listeners, their impacts and calibrations."""
    return {
        "sample_rate": tracks.sample_rate,
        "samples": tracks.count,
        "start": tracks.start,
        "listeners": [
            {
                "name": listener.name,
                "body_part": listener.body_part,
                **_mpeg(listener),
                **_calibration(listener.device),
                "impacts": listener.impacts.tolist(),
            }
            for listener in tracks.listeners
        ],
    }


def _mpeg(listener: ListenerTrack) -> JsonObject:
    part = body_part_of(listener)
    return (
        {} if part is None else {"mpeg_mask": part.mpeg_mask, "mpeg_target": list(part.mpeg_target)}
    )


def _calibration(device: FullScale | None) -> JsonObject:
    if device is None:
        return {}
    unit = "N" if device.is_force else "m/s^2"
    return {"full_scale": device.points, "full_scale_unit": unit}


def at_rate(tracks: Tracks, sample_rate: int) -> Tracks:
    """The tracks at another sample rate; 0: unchanged."""
    if sample_rate in (0, tracks.sample_rate):
        return tracks
    rows = (
        np.asarray(tracks.samples[number], dtype=np.float64)
        for number in range(len(tracks.listeners))
    )
    samples = np.array(
        [resample(row, tracks.sample_rate, sample_rate) for row in rows], dtype=np.float32
    )
    return Tracks(tracks.listeners, sample_rate, samples, tracks.start)


def write_wav(tracks: Tracks, path: Path, encoding: str = "pcm16", comment: str = "") -> None:
    """Write the samples as ``pcm16`` or ``float32``, in pieces, with a comment (``LIST``/``INFO``).
    Raises ValueError for more than a WAV file can hold."""
    channels = len(tracks.listeners)
    width = np.dtype(TYPES[encoding]).itemsize
    size = channels * tracks.count * width
    header = _header(
        channels, tracks.sample_rate, width, _CODES[encoding], tracks.count, _info(comment)
    )
    if channels > 65535 // width or len(header) + size - 8 > MAX_RIFF:
        raise ValueError(
            f"{path}: {channels} listeners and {tracks.duration:g} s are more than a WAV file "
            "can hold"
        )
    with atomic_file(path) as file:
        file.write(header)
        _write_samples(file, tracks, encoding)


def _header(channels: int, rate: int, width: int, code: int, count: int, info: bytes) -> bytes:
    """The header of a WAV file in the extensible form.

    Args:
        channels: their number.
        rate: samples per second.
        width: bytes of a sample.
        code: of the format of samples: 1 integer, 3 float.
        count: number of samples in a channel.
        info: further chunks before the samples.
    """
    size = channels * count * width
    form = struct.pack(
        "<HHIIHHHHIH",
        0xFFFE,
        channels,
        rate,
        rate * channels * width,
        channels * width,
        8 * width,
        22,
        8 * width,
        0,
        code,
    )
    form += _REST_OF_GUID
    fact = b"fact" + struct.pack("<II", 4, count) if code == 3 else b""
    chunks = (
        b"WAVE"
        + b"fmt "
        + struct.pack("<I", len(form))
        + form
        + fact
        + info
        + b"data"
        + struct.pack("<I", size & MAX_RIFF)
    )
    return b"RIFF" + struct.pack("<I", (len(chunks) + size) & MAX_RIFF) + chunks


def _info(comment: str) -> bytes:
    """The chunk of a comment, of even length and ended by a zero."""
    text = comment.encode() + b"\0"
    text += b"\0" * (len(text) % 2)
    entry = b"INFOICMT" + struct.pack("<I", len(text)) + text
    return b"LIST" + struct.pack("<I", len(entry)) + entry if comment else b""


def _write_samples(file: BinaryIO, tracks: Tracks, encoding: str) -> None:
    for block in encoded(tracks, encoding):
        file.write(np.ascontiguousarray(block.T).tobytes())


def encoded(tracks: Tracks, encoding: str) -> Iterator[NDArray[Any]]:
    """The samples in pieces, as 16 bit integers with full scale 32,768, or as 32 bit floats;
    little-endian."""
    for block in tracks.blocks():
        if encoding == "pcm16":
            yield np.clip(np.rint(block * 32768.0), -32768, 32767).astype("<i2")
        else:
            yield block.astype("<f4")


def compare_encoded(encoding: str, measured: SampleComparison) -> None:
    """Measure the losses of encoding the samples."""
    for coded in encoded(measured.tracks, encoding):
        for number, values in enumerate(coded / np.float64(FULL_SCALE[encoding])):
            measured.add(number, values)


def stored_samples(path: Path) -> tuple[NDArray[np.floating], float]:
    """The samples (channels, n) of a WAV file and their rate [Hz]. They are in a temporary file,
    which is removed with them, to save memory.

    Raises ValueError if the file is broken or has samples beyond ``MAX_SAMPLE``, and OSError.
    """
    with open_regular(path) as file:
        wav = WavFile(file)
        kept = tempfile.TemporaryFile(prefix="haptic-tracks-")  # noqa: SIM115
        for first in range(0, wav.count, CHUNK):
            samples = wav.read(first, min(first + CHUNK, wav.count))
            if not (np.abs(samples) <= MAX_SAMPLE).all():
                raise ValueError(f"has samples that are not finite or beyond ±{MAX_SAMPLE:g}")
            kept.write(samples.tobytes())
    kept.flush()
    return np.memmap(kept, dtype="<f8", mode="r", shape=(wav.count, wav.channels)).T, wav.rate


def read(path: Path) -> VibrationFile:
    """The channels, named by the side-car if there is one. Raises FormatError or OSError."""
    try:
        stored, rate = stored_samples(path)
    except ValueError as error:
        raise FormatError(path, "/", str(error)) from None
    named, losses = _named(path, len(stored))
    return VibrationFile(
        tuple(
            Channel(
                name,
                stored.shape[1] / rate,
                samples=stored[number],
                sample_rate=rate,
                body_part=body_part,
                device=device,
            )
            for number, (name, body_part, device) in enumerate(named)
        ),
        losses,
        stored=stored,
    )


def _named(
    path: Path, count: int
) -> tuple[list[tuple[str, str, FullScale | None]], tuple[str, ...]]:
    """Name, body part and calibration of each channel, from the side-car if it fits; and why it is
    not used."""
    beside = path.with_name(path.name + ".json")
    losses = tuple[str, ...]()
    if beside.is_file():
        try:
            listeners = read_json(beside)["listeners"]
            if len(listeners) == count:
                return [
                    (str(form["name"]), str(form["body_part"]), _device(form)) for form in listeners
                ], ()
            reason = f"it describes {len(listeners)} channels, not {count}"
        except KeyError as error:
            reason = f"{error} is missing"
        except FormatError as error:
            reason = error.reason
        except (OSError, TypeError, ValueError) as error:
            reason = str(error)
        losses = (f"{beside.name} is not used: {reason}",)
    return [
        (path.stem if count == 1 else f"{path.stem} {number}", "", None)
        for number in range(1, count + 1)
    ], losses


def _device(form: Form) -> FullScale | None:
    """The calibration that a side-car gives a listener. Raises ValueError."""
    unit = form.get("full_scale_unit", "m/s^2")
    points = declared(Listener)["full_scale"].checked(form.get("full_scale", ()))
    declared(Listener)["full_scale_unit"].checked(unit)
    return FullScale(points, unit == "N") if points else None
