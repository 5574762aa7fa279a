"""What is exported, in one value, and what formats share when they write it."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..scene.body import BODY_PART, BodyPart
from ..scene.values import HapticScene
from .io.atomic import atomic_file
from .io.file_names import file_stems
from .tracks.tracks import ListenerTrack, Tracks

if TYPE_CHECKING:
    from ..modalities import ModalityScene
    from .scene.devices import DeviceMapping
    from .scene.materials_json import LibraryMaterial
    from .scene.recording import Recording

EDITOR = "Haptic Tracing"


def _today() -> str:
    return date.today().isoformat()


@dataclass(frozen=True, slots=True, eq=False)
class Export:
    """``name`` is that of the scene: files are called after it. ``date`` (ISO 8601) goes into formats that ask for one."""

    name: str
    scene: HapticScene | None = None
    tracks: Tracks | None = None
    recording: Recording | None = None
    devices: tuple[DeviceMapping, ...] = ()
    modalities: tuple[ModalityScene, ...] = ()
    materials: tuple[LibraryMaterial, ...] = ()
    date: str = field(default_factory=_today)

    def need_tracks(self) -> Tracks:
        """The rendered tracks. Raises ValueError where there are none."""
        if self.tracks is None or not self.tracks.listeners:
            raise ValueError("tracks: this format carries what listeners feel, and there is no listener")
        return self.tracks

    def need_scene(self) -> HapticScene:
        """The scene. Raises ValueError where there is none."""
        if self.scene is None:
            raise ValueError("scene: this format carries the scene, and there is none")
        return self.scene


def body_part_of(listener: ListenerTrack) -> BodyPart | None:
    """Where on the body a listener is, if it is one of the parts of the body table."""
    return BODY_PART.get(listener.body_part)


def listener_files(export: Export, folder: Path, suffix: str) -> list[Path]:
    """A path per listener: ``<scene>.<listener><suffix>``, or ``<scene><suffix>`` for the only one."""
    listeners = export.need_tracks().listeners
    names = [export.name] if len(listeners) == 1 else [f"{export.name}.{listener.name}" for listener in listeners]
    return [folder / f"{stem}{suffix}" for stem in file_stems(names)]


def scene_file(export: Export, folder: Path, suffix: str) -> Path:
    """``<scene><suffix>``."""
    return folder / f"{file_stems([export.name])[0]}{suffix}"


def compact(value: Any) -> str:
    """JSON without spaces. Raises ValueError for NaN and infinity."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def table(keys: Sequence[str], *columns: Sequence[float]) -> str:
    """JSON of a list of objects that all have the same keys, from a list of finite numbers for each key."""
    form = "{" + ",".join(f'"{key}":%r' for key in keys) + "}"
    return "[" + ",".join([form % row for row in zip(*columns, strict=True)]) + "]"


def write_json(path: Path, value: Any) -> Path:
    """Write a small document to read, in one step."""
    return write_text(path, [json.dumps(value, ensure_ascii=False, allow_nan=False, indent=1), "\n"])


def write_text(path: Path, parts: Iterable[str]) -> Path:
    """Write text in UTF-8, in one step."""
    with atomic_file(path) as file:
        file.writelines(part.encode("utf-8") for part in parts)
    return path


def common_losses(tracks: Tracks, *, body: bool) -> Iterator[str]:
    """What every target of rendered tracks leaves out; ``body``: it addresses parts of the body."""
    yield "the scene itself: objects, contacts, sources and functions"
    clipped = tracks.clipped()
    if clipped:
        yield f"{clipped} samples beyond full scale are cut"
    nowhere = [listener.name for listener in tracks.listeners if body_part_of(listener) is None]
    if body and nowhere:
        yield "the place of listeners on no known body part: " + ", ".join(nowhere)


def clipped(samples: NDArray[np.floating]) -> NDArray[np.floating]:
    """Samples kept within ±1."""
    return np.asarray(np.clip(samples, -1.0, 1.0))
