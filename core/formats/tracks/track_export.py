"""Functions shared by the formats of rendered tracks: file names, clipping and losses."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

from ...forms import Form
from ...scene.body import BODY_PART, BodyPart
from ..io.file_names import file_stem
from .listener_tracks import ListenerTrack, Tracks

EDITOR = "Haptic Tracing"


class TrackExport(Protocol):
    """The part of an export that formats of tracks use. ``date`` is in ISO 8601."""

    @property
    def name(self) -> str: ...
    @property
    def date(self) -> str: ...
    @property
    def provenance(self) -> Form: ...
    def need_tracks(self) -> Tracks:
        """The rendered tracks. Raises ValueError where there are none."""
        ...


def credit(export: TrackExport) -> str:
    """Program, version, settings and digest of the scene, in one line."""
    rest = dict(export.provenance)
    program = f"{rest.pop('program')} {rest.pop('version')}"
    return "; ".join([program, *(f"{key} {value}" for key, value in rest.items())])


def body_part_of(listener: ListenerTrack) -> BodyPart | None:
    """The listener's row of the body table; None if it has none."""
    return BODY_PART.get(listener.body_part)


def scene_file(name: str, folder: Path, suffix: str) -> Path:
    """``<name><suffix>``, with ``name`` made safe for every file system."""
    return folder / f"{file_stem(name)}{suffix}"


def common_losses(tracks: Tracks, *, body: bool) -> Iterator[str]:
    """The losses common to all formats of tracks. ``body``: the format addresses parts of the
    body."""
    yield "the scene itself: objects, contacts, sources and functions"
    clipped = tracks.clipped()
    if clipped:
        yield f"{clipped} samples beyond full scale are cut"
    unplaced = [listener.name for listener in tracks.listeners if body_part_of(listener) is None]
    if body and unplaced:
        yield "the place of listeners on no known body part: " + ", ".join(unplaced)
