"""Writes and reads all formats by name.

A format is an entry of `io.catalogue` and a module with ``write(export, folder, options)`` and ``loss(export, options)``; one that can be
imported also has ``read(path)``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any, cast

from .export import Export
from .io.catalogue import FORMATS as FORMATS
from .io.catalogue import READERS as READERS
from .io.catalogue import Format, named
from .io.error import FormatError
from .io.options import Value, complete
from .tracks.vibration_file import VibrationFile


@dataclass(frozen=True, slots=True)
class Written:
    """Result of writing: ``files`` in the order of writing, ``losses`` one sentence each."""

    files: tuple[Path, ...]
    losses: tuple[str, ...]


def losses(name: str, export: Export, chosen: Mapping[str, Value] = MappingProxyType({})) -> tuple[str, ...]:
    """What a format does not carry of an export, one sentence each. Raises ValueError if it can't be written at all."""
    form = named(name)
    return cast(tuple[str, ...], _module(form).loss(export, complete(form.options, chosen)))


def write(name: str, export: Export, folder: str | Path, chosen: Mapping[str, Value] = MappingProxyType({})) -> Written:
    """Write an export into an existing folder. Raises ValueError for invalid options or contents, and OSError."""
    form = named(name)
    module, values = _module(form), complete(form.options, chosen)
    lost = module.loss(export, values)
    return Written(tuple(module.write(export, Path(folder), values)), lost)


def read(path: str | Path) -> VibrationFile:
    """The vibrations in a file, by its suffix. Raises FormatError or OSError."""
    path = Path(path)
    if path.suffix.lower() not in READERS:
        raise FormatError(path, "/", f"can't be imported: the ending must be one of {', '.join(READERS)}")
    return cast(VibrationFile, _module(named(READERS[path.suffix.lower()])).read(path))


def _module(form: Format) -> Any:
    return import_module(f".{form.module}", __package__)
