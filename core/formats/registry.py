"""Writes and reads all formats by name.

A format is a `Format` of `io.catalogue` and a module with ``write(export, folder, options,
measured)``, ``loss(export, options)`` and ``comparison(tracks, options, progress)``; one that can
be imported also has ``read(path)``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any, cast

from ..frozen import frozen
from .export import Export
from .io.atomic import staging
from .io.catalogue import Format, Value, complete, named, readers
from .io.error import FormatError
from .tracks.fidelity import Fidelity, Progress
from .tracks.vibration_file import VibrationFile


@frozen
class Written:
    """Result of writing: ``files`` in the order of writing, ``losses`` one sentence each, the
    measured ones last.

    ``fidelity``: the measured losses, None without tracks or for silence. ``replaced``: those of
    the files that were there before.
    """

    files: tuple[Path, ...]
    losses: tuple[str, ...]
    fidelity: Fidelity | None = None
    replaced: tuple[Path, ...] = ()

    @property
    def is_poor(self) -> bool:
        """Whether the files keep little of the vibration."""
        return self.fidelity is not None and self.fidelity.is_poor


Consent = Callable[[Written], bool]
"""Called before files are replaced; returns whether to write."""


def losses(
    name: str, export: Export, chosen: Mapping[str, Value] = MappingProxyType({})
) -> tuple[str, ...]:
    """The losses of an export in a format, one sentence each. Raises ValueError if it cannot be
    written."""
    form = named(name)
    return tuple(_module(form).loss(export, complete(form.options, chosen)))


def write(
    name: str,
    export: Export,
    folder: str | Path,
    chosen: Mapping[str, Value] = MappingProxyType({}),
    consent: Consent | None = None,
    progress: Progress = None,
) -> Written:
    """Write an export into an existing folder, and measure the losses of the files.

    If consent is requested and refused, nothing is written, and the result has no files.
    ``progress`` is called with the measured share; if it raises an error, nothing is written.
    Raises ValueError for invalid options or contents, and OSError.

    Args:
        name: of the format.
        export: what is written.
        folder: an existing one.
        chosen: options of the format by name; defaults for the others.
        consent: asked before files are replaced; None: they are.
        progress: called with the share that has been measured; what it raises ends the writing.
    """
    form = named(name)
    module = _module(form)
    values = complete(form.options, chosen)
    lost = tuple(module.loss(export, values))
    with staging(Path(folder)) as place:
        has_tracks = export.tracks is not None and len(export.tracks.listeners) > 0
        measured = module.comparison(export.tracks, values, progress) if has_tracks else None
        files = module.write(export, place.folder, values, measured)
        fidelity: Fidelity | None = None if measured is None else measured.result()
        told = () if fidelity is None else fidelity.sentences()
        targets = place.targets(files)
        there = tuple(path for path in targets if path.exists())
        written = Written(tuple(targets), (*lost, *told), fidelity, there)
        if consent and there and not consent(written):
            return replace(written, files=())
        place.commit(files)
    return written


def read(path: str | Path) -> VibrationFile:
    """The vibrations in a file, by its suffix. Raises FormatError or OSError."""
    path = Path(path)
    known = readers()
    if path.suffix.lower() not in known:
        raise FormatError(
            path, "/", f"can't be imported: the ending must be one of {', '.join(known)}"
        )
    try:
        return cast(VibrationFile, _module(named(known[path.suffix.lower()])).read(path))
    except FormatError:
        raise
    except ValueError as error:  # a vibration beyond the limits of signals
        raise FormatError(path, "/", str(error)) from None


def _module(form: Format) -> Any:
    return import_module(form.module)
