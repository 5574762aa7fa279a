"""How much memory the content of a file may take."""

from __future__ import annotations

from pathlib import Path

from .error import FormatError

LEAST = 64 * 2**20
PER_BYTE = 50


class Budget:
    """The memory that the content of a file may take, in proportion to its size, so that a small file from a stranger fills no memory."""

    def __init__(self, path: Path) -> None:
        """Raises OSError."""
        self._path, self.size = path, budget_of(path.stat().st_size)
        self._left = float(self.size)

    def take(self, size: float, pointer: str = "/") -> None:
        """Take ``size`` bytes for the value at ``pointer``. Raises FormatError if there are not so many left."""
        self._left -= size
        if self._left < 0:
            raise FormatError(self._path, pointer, f"its content takes more than {self.size / 2**20:.0f} MB of memory")


def budget_of(size: int) -> int:
    """The memory for a file of ``size``, both in bytes."""
    return LEAST + PER_BYTE * size
