"""How many frames a command has traced: a bar on a terminal, nothing in a log, or lines that a farm
reads."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tqdm import tqdm

from . import was_interrupted


@contextmanager
def frame_bar(total: int, label: str, style: str = "bar") -> Iterator[Callable[[], None]]:
    """A bar of ``total`` frames, and what advances it by one; that raises KeyboardInterrupt after a
    Ctrl-C that Blender has dropped. ``style`` "openjd": a line for each percent, as workers of Open
    Job Description read it."""
    shown = -1
    with tqdm(total=total, desc=label, unit="frame", disable=style != "bar" or None) as bar:
        done = 0

        def advance() -> None:
            nonlocal done, shown
            if was_interrupted():
                raise KeyboardInterrupt
            bar.update()
            done += 1
            if style == "openjd" and (percent := 100 * done // total) != shown:
                print(f"openjd_progress: {percent}", flush=True)
                shown = percent

        yield advance
