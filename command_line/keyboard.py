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
        before = termios.tcgetattr(sys.stdin)
        try:
            tty.setcbreak(sys.stdin)
            yield lambda: sys.stdin.read(1) if select.select([sys.stdin], [], [], 0)[0] else ""
        finally:
            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)
