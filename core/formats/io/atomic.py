"""Writing a file, or several, in one step: complete or not at all. Several go into a hidden folder beside their target first."""

from __future__ import annotations

import os
import re
import secrets
import shutil
import sys
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

if sys.platform == "win32":
    import msvcrt

    def _lock(descriptor: int) -> None:
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _lock(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


_NAME = re.compile(r"\.[0-9a-f]{16}\.part")
_LOCK = "lock"


def lock(descriptor: int) -> bool:
    """Lock an open file until it is closed or the process ends. False if another process has locked it, which is then writing it."""
    try:
        _lock(descriptor)
    except OSError:
        return False
    return True


@contextmanager
def atomic_file(path: str | Path) -> Iterator[BinaryIO]:
    """A binary file that replaces ``path`` when the block ends without an error and is removed otherwise.

    It is written beside ``path`` and synchronised to the disk, so that the last step is a rename within one file system.
    """
    path = Path(path)
    temporary = path.with_name(f".{secrets.token_hex(8)}.part")
    file = temporary.open("xb")
    try:
        with file:  # closing may fail as well, on a full disk
            lock(file.fileno())
            yield file
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    except BaseException:
        temporary.unlink()
        raise


def write_bytes(path: str | Path, data: bytes) -> None:
    """Write ``data`` to ``path`` in one step."""
    with atomic_file(path) as file:
        file.write(data)


def write_text(path: Path, parts: Iterable[str]) -> Path:
    """Write text in UTF-8 in one step."""
    with atomic_file(path) as file:
        file.writelines(part.encode("utf-8") for part in parts)
    return path


class Staging:
    """The folder that files are written into."""

    def __init__(self, folder: Path, target: Path) -> None:
        self.folder, self._target = folder, target

    def targets(self, files: Collection[Path]) -> list[Path]:
        """The final paths of the files."""
        return [self._target / path.relative_to(self.folder) for path in files]

    def commit(self, files: Collection[Path]) -> None:
        """Move the files to their places, in this order; each replaces an existing file."""
        for path, target in zip(files, self.targets(files), strict=True):
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
