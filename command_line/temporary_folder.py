"""The temporary folder of Blender in this process, for all temporary files of a command.

Blender removes it where the program ends by itself; `remove` does so where it is ended from
outside.
"""

from __future__ import annotations

import shutil
import signal
import tempfile
from pathlib import Path

import bpy


def use() -> None:
    """Make all temporary files in it, and remove it also when a signal ends the program as farms
    and closed terminals do."""
    tempfile.tempdir = bpy.app.tempdir
    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)  # Windows has no SIGHUP
        if number is not None and signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, _remove_and_end)


def remove() -> None:
    """Remove it with all that is in it."""
    folder = Path(bpy.app.tempdir)
    if folder.name.startswith(
        "blender_"
    ):  # else Blender could not make one, and this is everybody's
        shutil.rmtree(folder, ignore_errors=True)


def _remove_and_end(number: int, _: object) -> None:
    remove()
    signal.signal(number, signal.SIG_DFL)
    signal.raise_signal(number)
