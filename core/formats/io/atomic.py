"""Writing files in one step: complete or not at all."""

from __future__ import annotations

import os
import secrets
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
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
