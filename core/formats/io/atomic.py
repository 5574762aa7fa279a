"""Writing a file, or several, in one step: complete or not at all. Several go into a hidden folder
beside their target first.

Windows refuses to replace a file that another program has open. What was written then stays beside
it.
"""

from __future__ import annotations

import os
import re
import secrets
import shutil
import sys
import time
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


_OPEN_ELSEWHERE = (5, 32, 33)  # ERROR_ACCESS_DENIED, ERROR_SHARING_VIOLATION, ERROR_LOCK_VIOLATION
_TRIES, _PAUSE = 10, 0.1  # indexers and virus scanners close a file within a second
_NAME = re.compile(r"\.[0-9a-f]{16}\.part")
_LOCK = "lock"


def lock(descriptor: int) -> bool:
    """Lock an open file until it is closed or the process ends. False if another process has locked
    it, which is then writing it."""
    try:
        _lock(descriptor)
    except OSError:
        return False
    return True


class WrittenBeside(OSError):
    """A file could not be replaced, because another program has it open; the text says where the
    new one is."""


def _replace(path: Path, target: Path) -> None:
    """Move a file to ``target``, which it replaces. Raises OSError, if another program has that
    open only after some tries."""
    for left in reversed(range(_TRIES)):
        try:
            path.replace(target)
            return
        except OSError as error:
            if not (_is_open_elsewhere(error) and left):
                raise
        time.sleep(_PAUSE)


def _is_open_elsewhere(error: OSError) -> bool:
    return getattr(error, "winerror", None) in _OPEN_ELSEWHERE


def _beside(path: Path) -> Path:
    """A free name beside ``path``: "track (2).wav"."""
    names = (
        path.with_name(f"{path.stem} ({number}){path.suffix}") for number in range(2, sys.maxsize)
    )
    return next(name for name in names if not name.exists())


@contextmanager
def _errors_of(own: Path, shown: Path) -> Iterator[None]:
    """Let errors of the hidden file or folder ``own``, and of what is in it, name what is ``shown``
    to the user instead."""
    try:
        yield
    except OSError as error:
        if isinstance(error.filename, str) and Path(error.filename).is_relative_to(own):
            error.filename = str(shown / Path(error.filename).relative_to(own))
        raise


@contextmanager
def atomic_file(path: str | Path) -> Iterator[BinaryIO]:
    """A binary file that replaces ``path`` when the block ends without an error and is removed
    otherwise.

    It is written beside ``path`` and synchronised to the disk, so that the last step is a rename
    within one file system. Raises OSError; `WrittenBeside` if the file is complete under another
    name.
    """
    path = Path(path)
    temporary = path.with_name(f".{secrets.token_hex(8)}.part")
    with _errors_of(temporary, path):
        file = temporary.open("xb")
    try:
        with file:  # closing may fail as well, on a full disk
            lock(file.fileno())
            yield file
            file.flush()
            os.fsync(file.fileno())
        _replace(temporary, path)
    except BaseException as error:
        if isinstance(error, OSError) and _is_open_elsewhere(error):
            other = _beside(path)
            temporary.replace(other)
            raise WrittenBeside(
                f"{path} is open in another program: the new file is {other.name}, beside it"
            ) from None
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
        """Move the files to their places, in this order; each replaces an existing file. If one
        can't be replaced, none is.

        Raises OSError; `WrittenBeside` if the files are complete in a folder beside their places.
        """
        places = dict(zip(files, self.targets(files), strict=True))
        before = {
            target: self.folder / f"before {number}"
            for number, target in enumerate(places.values())
            if target.exists()
        }
        for target, kept in before.items():
            _keep(target, kept)
        moved: list[Path] = []
        try:
            for path, target in places.items():
                target.parent.mkdir(parents=True, exist_ok=True)
                _replace(path, target)
                moved.append(path)
        except OSError as error:
            for path in moved:
                places[path].replace(path)
            for target, kept in before.items():
                if kept.exists() and not target.exists():
                    kept.replace(target)
            if _is_open_elsewhere(error):
                other = _beside(places[next(iter(files))].with_suffix(""))
                for path in files:
                    place = other / path.relative_to(self.folder)
                    place.parent.mkdir(parents=True, exist_ok=True)
                    path.replace(place)
                raise WrittenBeside(
                    f"{target} is open in another program: nothing was replaced, the new files "
                    f"are in {other}"
                ) from None
            raise


def _keep(path: Path, kept: Path) -> None:
    """Let a file be found under another name even after it is replaced."""
    try:
        os.link(path, kept)
    except OSError:  # the file system has no links
        shutil.copy2(path, kept)


@contextmanager
def staging(target: Path) -> Iterator[Staging]:
    """A folder for files on the way to ``target``, an existing folder; what was not committed is
    removed at the end.

    Remains of a killed process are removed as well. Raises OSError.
    """
    remove_abandoned(target)
    folder = target / f".{secrets.token_hex(8)}.part"
    with _errors_of(folder, target):
        folder.mkdir()
    try:
        with _errors_of(folder, target), (folder / _LOCK).open("wb") as file:
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
