"""Writing several files in one step: into a hidden folder beside the target, then moved there."""

from __future__ import annotations

import re
import secrets
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from .atomic import lock

_NAME = re.compile(r"\.[0-9a-f]{16}\.part")
_LOCK = "lock"


class Staging:
    """The folder that files are written into."""

    def __init__(self, folder: Path, target: Path) -> None:
        self.folder, self._target = folder, target

    def targets(self, files: Iterable[Path]) -> list[Path]:
        """The final paths of the files."""
        return [self._target / path.relative_to(self.folder) for path in files]

    def commit(self, files: Iterable[Path]) -> None:
        """Move the files to their places, in this order; each replaces an existing file."""
        for path in files:
            target = self._target / path.relative_to(self.folder)
            target.parent.mkdir(parents=True, exist_ok=True)
            path.replace(target)


@contextmanager
def staging(target: Path) -> Iterator[Staging]:
    """A folder for files on the way to ``target``, an existing folder; what was not committed is removed at the end.

    Remains of a killed process are removed as well. Raises OSError.
    """
    remove_abandoned(target)
    folder = target / f".{secrets.token_hex(8)}.part"
    folder.mkdir()
    try:
        with (folder / _LOCK).open("wb") as file:
            lock(file.fileno())
            yield Staging(folder, target)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def remove_abandoned(folder: Path) -> None:
    """Remove the unfinished files and folders in ``folder`` that no process is writing."""
    for path in folder.iterdir():
        if not _NAME.fullmatch(path.name):
            continue
        locked = path / _LOCK if path.is_dir() else path
        with suppress(OSError):
            if not locked.exists() or _is_free(locked):
                shutil.rmtree(path) if path.is_dir() else path.unlink()


def _is_free(path: Path) -> bool:
    """Whether no process holds the lock of a file."""
    with path.open("rb+") as file:
        return lock(file.fileno())
