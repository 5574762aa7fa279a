"""The levels of the last step in the terminal, in one line."""

from __future__ import annotations

import shutil
import time
from typing import TextIO

from .. import one_line
from .conversation import Conversation

INTERVAL = 0.2
"""Seconds between two lines."""
_FLOOR, _WIDTH = -60.0, 10


class LiveView:
    """Rewrites one line of a terminal; writes nothing elsewhere."""

    def __init__(self, out: TextIO) -> None:
        self._out = out
        self._shown = 0.0

    def show(self, conversation: Conversation) -> None:
        """Show the last step, if the line is old enough."""
        step, now = conversation.last, time.monotonic()
        if step is None or now - self._shown < INTERVAL or not self._out.isatty():
            return
        self._shown = now
        meters = [f"{name} {meter(level.level)}" for name, level in step.levels.items()]
        line = one_line(f"{step.time:8.2f} s  " + "  ".join(meters))
        self._out.write(
            "\r"
            + line[: shutil.get_terminal_size().columns - 1].ljust(
                shutil.get_terminal_size().columns - 1
            )
        )
        self._out.flush()


def meter(level: float | None) -> str:
    """A bar for a level in decibels of full scale, with its number."""
    if level is None:
        return "silent".ljust(_WIDTH + 8)
    filled = round(min(max(1 - level / _FLOOR, 0.0), 1.0) * _WIDTH)
    return f"{'#' * filled}{'.' * (_WIDTH - filled)} {level:4.0f} dB"
