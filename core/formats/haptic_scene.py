"""The haptic scene file: scene, materials, devices, frames and tracks."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ..forms import Form
from .export import Export
from .io.catalogue import SCENE
from .io.strict_json import read_json
from .scene.frames_json import frame_to_dict, recording_from_dict
from .scene.lists_json import device_to_dict, devices_from_dict, materials_from_dict
from .scene.motion import packed
from .scene.scene_json import (
    PROVENANCE,
    scene_of,
    scene_to_dict,
    valid_document,
    write_document,
)
from .scene.tracks_json import tracks_from_dict, tracks_to_dict
from .scene.values_json import item_to_dict
from .tracks import wav
from .tracks.fidelity import Progress, SampleComparison
from .tracks.listener_tracks import Tracks
from .tracks.track_export import credit, scene_file

SUFFIX = SCENE.suffix


def loss(export: Export, options: Form) -> Iterator[str]:
    """What the file does not carry, one sentence each."""
    export.need_scene()
    if export.recording is not None and not options["frames"]:
        yield "what changes over time"
    if export.tracks is not None and options["tracks"] == "none":
        yield "the rendered tracks, which can be rendered again"
    elif export.tracks is not None and options["encoding"] == "pcm16":
        yield f"{wav.ROUNDING} in the tracks"


def comparison(tracks: Tracks, options: Form, progress: Progress) -> SampleComparison | None:
    """What compares the tracks in the file with the rendered ones; None without any."""
    return None if options["tracks"] == "none" else SampleComparison(tracks, progress)


def write(
    export: Export, folder: Path, options: Form, measured: SampleComparison | None = None
) -> list[Path]:
    """Write ``<scene>.json`` or ``.json.gz``, and ``<scene>.tracks.wav`` if asked to."""
    if export.tracks is not None and measured is not None:
        wav.compare_encoded(options["encoding"], measured)
    path = scene_file(export.name, folder, SUFFIX)
    path = path.with_name(f"{path.name}.gz") if options["compressed"] else path
    return write_export(
        export,
        path,
        frames=options["frames"],
        tracks=options["tracks"],
        encoding=options["encoding"],
    )


def write_export(
    export: Export, path: Path, frames: bool = True, tracks: str = "none", encoding: str = "pcm16"
) -> list[Path]:
    """Write to ``path``, compressed if it ends in ``.gz``. Raises ValueError or OSError.

    Args:
        export: the scene with its frames and tracks.
        path: of the file, compressed if it ends in ``.gz``.
        frames: whether frames are written.
        tracks: how tracks are written, see the options of the format.
        encoding: of the tracks' samples.
    """
    document = scene_to_dict(export.need_scene())
    extras = {PROVENANCE: None, **document.pop("extras", {})}
    extras[PROVENANCE] = dict(export.provenance)
    files = [path]
    if export.materials:
        document["materials"] = [item_to_dict(material) for material in export.materials]
    if export.devices:
        document["devices"] = [device_to_dict(device) for device in export.devices]
    if export.recording is not None and frames:
        document["frame_rate"] = export.recording.frame_rate
        document["frame_start"] = export.recording.frame_start
        motions, recorded = packed(export.recording.frames)
        if motions:
            document["motions"] = motions
        document["frames"] = (frame_to_dict(frame) for frame in recorded)
    if export.tracks is not None and tracks != "none":
        sidecar = path.with_name(path.name.removesuffix(".gz").removesuffix(SUFFIX) + ".tracks.wav")
        if tracks == "wav":
            wav.write_wav(export.tracks, sidecar, encoding, credit(export))
            files.insert(0, sidecar)
        document["tracks"] = tracks_to_dict(
            export.tracks, encoding, sidecar.name if tracks == "wav" else None
        )
    write_document({**document, "extras": extras}, path)
    return files


def read_export(path: str | Path) -> Export:
    """The content of a ``.json`` or ``.json.gz`` file. Raises FormatError or OSError."""
    return export_of(valid_document(read_json(path), path), Path(path))


def export_of(document: Form, path: Path) -> Export:
    """The content of a valid document, which was read from ``path``. Raises FormatError."""
    scene = scene_of(document, path)
    return Export(
        name=path.name.removesuffix(".gz").removesuffix(SUFFIX),
        scene=scene,
        devices=devices_from_dict(document, scene, path),
        materials=materials_from_dict(document, path),
        recording=recording_from_dict(document, scene, path),
        tracks=tracks_from_dict(document, path),
    )
