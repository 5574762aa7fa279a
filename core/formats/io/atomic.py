"""Writing files in one step: complete or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from .file_lock import lock


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
