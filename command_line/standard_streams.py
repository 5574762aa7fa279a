"""Standard input and output: ``-`` as a file's name, and stdout for results alone.

Readers and writers of formats need files. What comes from standard input is kept in a temporary
file, and what goes to standard output is written into one first; messages name neither.
"""

from __future__ import annotations

import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from types import FrameType
from typing import NoReturn, TextIO

DASH = Path("-")
INPUT, OUTPUT = "standard input", "standard output"
INPUTS = {"scene": ".json"}
"""The arguments of commands that may be ``-``, and the suffix of what then comes in."""
MAX_BYTES = 1 << 30
_CHUNK = 1 << 20

_folders: list[tempfile.TemporaryDirectory[str]] = []
"""The temporary folder of this run, if it needs one."""


def keep_stdout_for_results() -> None:
    """Send what Blender's own code prints to stderr: the process' stdout belongs to
    ``sys.stdout``."""
    stdout = sys.__stdout__
    if stdout is None or sys.stdout is not stdout or stdout.fileno() != 1:
        return  # another program runs this one and reads what it prints
    own = os.dup(1)
    os.dup2(2, 1)
    sys.stdout = os.fdopen(own, "w", encoding=stdout.encoding, errors=stdout.errors)


def from_input(suffix: str) -> Path:
    """A file with this suffix and the content of standard input. Raises ValueError for more than
    `MAX_BYTES`."""
    kept = folder() / f"{INPUT}{suffix}"
    left = MAX_BYTES
    with kept.open("wb") as file:
        while piece := sys.stdin.buffer.read(_CHUNK):
            left -= len(piece)
            if left < 0:
                raise ValueError(f"{INPUT}: larger than {MAX_BYTES >> 20} MiB")
            file.write(piece)
    return kept


def for_output(path: Path, suffix: str) -> Path:
    """``path``, or for ``-`` the file that `put_out` is to be called with."""
    return path if path != DASH else folder() / f"{OUTPUT}{suffix}"


def put_out(files: Sequence[Path], stdout: TextIO) -> None:
    """Copy the first of these files to standard output. Raises ValueError if the others are more
    than its descriptions, such as track.wav.json of track.wav."""
    first, *others = files
    if not all(path.name.startswith(f"{first.name}.") for path in others):
        raise ValueError(f"{OUTPUT}: the result is {len(files)} files; name a folder or a file")
    stdout.flush()
    with first.open("rb") as file:
        shutil.copyfileobj(file, stdout.buffer)
    stdout.buffer.flush()


def in_words(text: str) -> str:
    """A message with the temporary files called what they stand for."""
    for own in _folders:
        for path in Path(own.name).iterdir():
            text = text.replace(str(path), path.stem).replace(path.name, path.stem)
    return text


def remove() -> None:
    """Remove the temporary folder."""
    while _folders:
        _folders.pop().cleanup()


def folder() -> Path:
    """The temporary folder of this run."""
    if not _folders:
        _folders.append(tempfile.TemporaryDirectory(prefix="haptic_tracing_"))
        leave_in_order_when_ended()
    return Path(_folders[-1].name)


def leave_in_order_when_ended() -> None:
    """From now on SIGTERM raises SystemExit, so that what is open is closed on the way out."""
    if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        signal.signal(signal.SIGTERM, _end)


def _end(number: int, frame: FrameType | None) -> NoReturn:
    raise SystemExit(128 + number)
