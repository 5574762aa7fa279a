"""The signal library: files of one signal each, in the format of scene files; built-in ones, then
the user's own.

Any signal can be stored, including recordings; files are validated like scenes.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import bpy
import numpy as np

from ...core.arrays import FloatArray
from ...core.formats.io.file_names import file_stem
from ...core.formats.io.json_text import write_json
from ...core.formats.io.strict_json import parse_json, read_bytes
from ...core.signals import Signal, signal_from_dict

_SHIPPED = Path(__file__).parents[1] / "signals"
_MOST_FILES = 60  # of a folder
_MAX_BYTES = 2**24
_SIDE = 64  # pixels
_FINE = 16  # samples for each column at least
_RATE = 2000.0
_LONGEST_SHOWN = 4.0


def own_folder() -> Path:
    """The folder of the user's own signals, which need not exist."""
    return Path(bpy.utils.user_resource("CONFIG", path="haptic_signals"))


def files() -> list[Path]:
    """The files of the library, by name, the built-in ones first."""
    return [
        path
        for folder in (_SHIPPED, own_folder())
        for path in sorted(folder.glob("*.json"))[:_MOST_FILES]
    ]


def read(path: Path) -> Signal:
    """The signal in a file. Raises ValueError, which names the place in the file, or OSError."""
    return signal_from_dict(parse_json(read_bytes(path, _MAX_BYTES), path))


def save(name: str, signal: Signal) -> Path:
    """Write a signal to the user's folder, replacing one of that name. Raises OSError."""
    own_folder().mkdir(parents=True, exist_ok=True)
    return write_json(own_folder() / f"{file_stem(name)}.json", signal.to_dict())


def picture(path: Path) -> tuple[str, tuple[float, ...]]:
    """An identifier of the current content of a file, and the waveform of its signal as a picture
    of 64 x 64 RGBA pixels from the bottom; an empty one if it cannot be read."""
    try:
        changed = path.stat().st_mtime_ns
        return f"{path} {changed}", _picture(path, changed)
    except (OSError, ValueError):
        return f"{path} unreadable", (0.0,) * (4 * _SIDE * _SIDE)


@lru_cache(maxsize=128)
def _picture(path: Path, changed: int) -> tuple[float, ...]:
    """The picture of a file with the modification time ``changed``."""
    signal = read(path)
    seconds = min(signal.duration, _LONGEST_SHOWN)
    count = max(round(seconds * _RATE), _SIDE * _FINE)
    columns = np.array_split(signal.sample(0, count, count / seconds), _SIDE)
    low, high = np.array([(column.min(), column.max()) for column in columns]).T
    low, high = np.array([low, high]) / max(high.max(), -low.min(), 1e-9)
    heights: FloatArray = np.linspace(-1.0, 1.0, _SIDE)[:, None]
    pixels = np.zeros((_SIDE, _SIDE, 4))
    pixels[(heights >= low - 1 / _SIDE) & (heights <= high + 1 / _SIDE)] = 0.95, 0.6, 0.2, 1.0
    return tuple(pixels.ravel().tolist())
