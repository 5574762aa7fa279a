"""All formats by name.

A format is a module with ``LABEL``, ``SUFFIX``, ``OPTIONS``, ``write(export, folder, options)`` and ``loss(export, options)``; one that can
be imported also has ``read(path)``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any, cast

from .export import Export
from .io.error import FormatError
from .io.options import Option, Value, complete
from .tracks.vibration_file import VibrationFile

FORMATS: Mapping[str, str] = MappingProxyType(
    {
        "scene": "haptic_scene",
        "wav": "tracks.wav",
        "ohm": "tracks.ohm",
        "hjif": "tracks.hjif",
        "wyvrn": "tracks.wyvrn",
        "haptic": "tracks.haptic",
        "ahap": "tracks.ahap",
        "tact": "tracks.tact",
        "hla": "tracks.hla",
        "csv": "tracks.csv_table",
        "npz": "tracks.npz",
    }
)
"""The module of each format, imported when it is used."""

READERS: Mapping[str, str] = MappingProxyType({".wav": "wav", ".hjif": "hjif", ".haptic": "haptic", ".ahap": "ahap", ".haps": "wyvrn"})
"""The format of each file suffix that can be imported."""


@dataclass(frozen=True, slots=True)
class Written:
    """Result of writing: ``files`` in the order of writing, ``losses`` one sentence each."""

    files: tuple[Path, ...]
    losses: tuple[str, ...]


def label(name: str) -> str:
    """The name of a format in menus."""
    return str(_module(name).LABEL)


def suffix(name: str) -> str:
    """The suffix of a format's files."""
    return str(_module(name).SUFFIX)


def options(name: str) -> tuple[Option, ...]:
    """The options of a format."""
    return cast(tuple[Option, ...], _module(name).OPTIONS)


def losses(name: str, export: Export, chosen: Mapping[str, Value] = MappingProxyType({})) -> tuple[str, ...]:
    """What a format does not carry of an export, one sentence each. Raises ValueError if it can't be written at all."""
    module = _module(name)
    return cast(tuple[str, ...], module.loss(export, complete(module.OPTIONS, chosen)))


def write(name: str, export: Export, folder: str | Path, chosen: Mapping[str, Value] = MappingProxyType({})) -> Written:
    """Write an export into an existing folder. Raises ValueError for invalid options or contents, and OSError."""
    module = _module(name)
    values = complete(module.OPTIONS, chosen)
    lost = module.loss(export, values)
    return Written(tuple(module.write(export, Path(folder), values)), lost)


def read(path: str | Path) -> VibrationFile:
    """The vibrations in a file, by its suffix. Raises FormatError or OSError."""
    path = Path(path)
    if path.suffix.lower() not in READERS:
        raise FormatError(path, "/", f"can't be imported: the ending must be one of {', '.join(READERS)}")
    return cast(VibrationFile, _module(READERS[path.suffix.lower()]).read(path))


def _module(name: str) -> Any:
    if name not in FORMATS:
        raise ValueError(f"format {name!r} is unknown: use one of {', '.join(FORMATS)}")
    return import_module(f".{FORMATS[name]}", __package__)
