"""How much memory the content of a file may take."""

from __future__ import annotations

import math
from pathlib import Path

from .error import FormatError

LEAST = 64 * 2**20
PER_BYTE = 50
_DOCUMENT = 8 * 2**20
_DOCUMENT_PER_BYTE = 25


class Budget:
    """The memory that the content of a file may take, in proportion to its size, so that a small
    file from a stranger fills no memory."""

    def __init__(self, path: Path, is_json: bool = False) -> None:
        """is_json: the document itself is in memory as well. Raises OSError."""
        size = path.stat().st_size
        self._path = path
        self._size = budget_of(size)
        self._left = self._size - is_json * (_DOCUMENT + _DOCUMENT_PER_BYTE * size)

    def take(self, size: float, pointer: str = "/") -> None:
        """Take ``size`` bytes for the value at ``pointer``. Raises FormatError if there are not so
        many left."""
        self._left -= math.ceil(size)
        if self._left < 0:
            raise FormatError(
                self._path,
                pointer,
                f"its content takes more than {self._size / 2**20:.0f} MB of memory",
            )


def budget_of(size: int) -> int:
    """The memory for a file of ``size``, both in bytes."""
    return LEAST + PER_BYTE * size
