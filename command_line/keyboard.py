"""Keys pressed in the terminal while a command runs."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

if sys.platform == "win32":
    import msvcrt

    @contextmanager
    def pressed_keys() -> Iterator[Callable[[], str]]:
        """What returns the next key that was pressed, or "" for none."""
        yield lambda: msvcrt.getwch() if msvcrt.kbhit() else ""

else:
    import os
    import select
    import termios
    import tty

    @contextmanager
    def pressed_keys() -> Iterator[Callable[[], str]]:
        """What returns the next key that was pressed, or "" for none. Keys are read one by one and
        not shown; without a terminal there are none."""
        if not sys.stdin.isatty():
            yield str
            return
        terminal = sys.stdin.fileno()
        before = termios.tcgetattr(terminal)
        try:
            tty.setcbreak(terminal)
            yield (
                lambda: (
                    os.read(terminal, 1).decode(errors="replace")
                    if select.select([terminal], [], [], 0)[0]
                    else ""
                )
            )
        finally:
            termios.tcsetattr(terminal, termios.TCSADRAIN, before)
