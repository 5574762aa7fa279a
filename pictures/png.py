"""PNG encoding (ISO/IEC 15948) without colour management, so that pixels reach the file
unchanged."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..core.formats.io.atomic import write_bytes


def write_png(path: str | Path, pixels: NDArray[np.uint8]) -> None:
    """Write ``pixels`` (height, width, 3 or 4), top row first."""
    height, width, channels = pixels.shape
    # Every row begins with its filter: none.
    rows = np.zeros((height, 1 + width * channels), dtype=np.uint8)
    rows[:, 1:] = pixels.reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8, {3: 2, 4: 6}[channels], 0, 0, 0)
    body = (
        _chunk(b"IHDR", header)
        + _chunk(b"sRGB", b"\0")
        + _chunk(b"IDAT", zlib.compress(rows.tobytes(), 6))
        + _chunk(b"IEND", b"")
    )
    write_bytes(path, b"\x89PNG\r\n\x1a\n" + body)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
