"""The rendered tracks of a haptic scene file: in the file itself, or in a WAV file beside it."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...forms import Form, JsonObject
from ..io.error import FormatError
from ..tracks.listener_tracks import ListenerTrack, Tracks
from ..tracks.wav import FULL_SCALE, TYPES, encoded, stored_samples

MAX_INLINE = 192 * 2**20
"""Maximum number of bytes of samples in a scene file itself."""


def tracks_to_dict(tracks: Tracks, encoding: str, sidecar: str | None) -> JsonObject:
    """The JSON object of the tracks, with the name of the WAV file beside it, or with their
    samples.

    Raises ValueError for more than ``MAX_INLINE`` bytes of samples.
    """
    form: JsonObject = {"sample_rate": tracks.sample_rate, "start": tracks.start}
    listeners: list[JsonObject] = [
        {"name": track.name, "body_part": track.body_part, "impacts": track.impacts.tolist()}
        for track in tracks.listeners
    ]
    if sidecar is not None:
        return {**form, "file": sidecar, "listeners": listeners}
    size = len(listeners) * tracks.count * np.dtype(TYPES[encoding]).itemsize
    if size > MAX_INLINE:
        raise ValueError(
            f"tracks: {size / 2**20:.0f} MiB are too many for the scene file: write them into a "
            "WAV file beside it"
        )
    blocks = list(encoded(tracks, encoding))
    for number, listener in enumerate(listeners):
        listener["samples"] = base64.b64encode(
            b"".join(block[number].tobytes() for block in blocks)
        ).decode("ascii")
    return {**form, "encoding": encoding, "listeners": listeners}


def tracks_from_dict(document: Form, file: str | Path) -> Tracks | None:
    """The tracks of a validated document, or None where it has none. Raises FormatError or
    OSError."""
    if "tracks" not in document:
        return None
    form = document["tracks"]
    samples = _beside(form, file) if "file" in form else _inline(form, file)
    listeners = []
    for i, track in enumerate(form["listeners"]):
        try:
            listeners.append(
                ListenerTrack(
                    track["name"],
                    track.get("body_part", ""),
                    np.array(track.get("impacts", [])).reshape(-1, 2),
                )
            )
        except ValueError as error:
            raise FormatError(
                file, f"/tracks/listeners/{i}/impacts", str(error).partition(": ")[2]
            ) from None
    try:
        return Tracks(
            tuple(listeners), int(form["sample_rate"]), samples, float(form.get("start", 0.0))
        )
    except ValueError as error:
        raise FormatError(file, "/tracks", str(error)) from None


def _beside(form: Form, file: str | Path) -> NDArray[np.floating]:
    name = form["file"]
    place = "/tracks/file"
    if name != Path(name).name or "\\" in name or ":" in name or name in (".", ".."):
        raise FormatError(file, place, f"{name!r} is not the name of a file in the same folder")
    path = Path(file).parent / name
    try:
        if path.exists() and not path.is_file():
            raise ValueError("is not a regular file")
        stored, rate = stored_samples(path)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise FormatError(file, place, f"{name}: {reason}") from None
    if rate != form["sample_rate"] or len(stored) != len(form["listeners"]):
        wanted = f"{len(form['listeners'])} channels at {form['sample_rate']} Hz"
        has = f"{name} has {len(stored)} channels at {rate:g} Hz"
        raise FormatError(file, place, f"{has}, not {wanted}")
    return stored


def _inline(form: Form, file: str | Path) -> NDArray[np.floating]:
    kind = np.dtype(TYPES[form["encoding"]])
    rows: list[NDArray[Any]] = []
    for i, listener in enumerate(form["listeners"]):
        try:
            data = base64.b64decode(listener["samples"], validate=True)
        except ValueError:
            raise FormatError(file, f"/tracks/listeners/{i}/samples", "is not base64") from None
        if len(data) % kind.itemsize or (rows and len(data) != rows[0].nbytes):
            raise FormatError(
                file,
                f"/tracks/listeners/{i}/samples",
                f"{len(data)} bytes are no whole samples or not as many as others",
            )
        rows.append(np.frombuffer(data, dtype=kind))
    return np.array(rows) / np.float32(FULL_SCALE[form["encoding"]])
