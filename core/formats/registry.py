"""All formats by name: each is a module with a writer, a reader if it has one, options, and a report of what it can't carry.

A module has ``LABEL``, ``SUFFIX``, ``OPTIONS``, ``write(export, folder, options)`` and ``loss(export, options)``; one that can be imported
has ``read(path)`` too.
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
"""The module of each format, imported when it is asked for."""

READERS: Mapping[str, str] = MappingProxyType({".wav": "wav", ".hjif": "hjif", ".haptic": "haptic", ".ahap": "ahap", ".haps": "wyvrn"})
"""The format of each kind of file that vibrations can be imported from."""


@dataclass(frozen=True, slots=True)
class Written:
    """What writing gave: ``files`` in the order of writing, ``losses`` in words."""

    files: tuple[Path, ...]
    losses: tuple[str, ...]


def label(name: str) -> str:
    """What menus call a format."""
    return str(_module(name).LABEL)


def suffix(name: str) -> str:
    """How the names of its files end."""
    return str(_module(name).SUFFIX)


def options(name: str) -> tuple[Option, ...]:
    """The options of a format."""
    return cast(tuple[Option, ...], _module(name).OPTIONS)


def losses(name: str, export: Export, chosen: Mapping[str, Value] = MappingProxyType({})) -> tuple[str, ...]:
    """What a format can't carry of an export, in words. Raises ValueError where it can't be written at all."""
    module = _module(name)
    return cast(tuple[str, ...], module.loss(export, complete(module.OPTIONS, chosen)))


def write(name: str, export: Export, folder: str | Path, chosen: Mapping[str, Value] = MappingProxyType({})) -> Written:
    """Write an export into an existing folder. Raises ValueError for options or contents that don't fit, OSError."""
    module = _module(name)
    values = complete(module.OPTIONS, chosen)
    lost = module.loss(export, values)
    return Written(tuple(module.write(export, Path(folder), values)), lost)


def read(path: str | Path) -> VibrationFile:
    """The vibrations in a file, by its ending. Raises FormatError or OSError."""
    path = Path(path)
    if path.suffix.lower() not in READERS:
        raise FormatError(path, "/", f"can't be imported: the ending must be one of {', '.join(READERS)}")
    return cast(VibrationFile, _module(READERS[path.suffix.lower()]).read(path))


def _module(name: str) -> Any:
    if name not in FORMATS:
        raise ValueError(f"format {name!r} is unknown: use one of {', '.join(FORMATS)}")
    return import_module(f".{FORMATS[name]}", __package__)
