"""The bar of frames that a command has traced."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tqdm import tqdm

from . import was_interrupted


@contextmanager
def frame_bar(total: int, label: str) -> Iterator[Callable[[], None]]:
    """A bar of ``total`` frames, and what advances it by one; that raises KeyboardInterrupt after a
    Ctrl-C that Blender has dropped."""
    with tqdm(total=total, desc=label, unit="frame") as bar:

        def advance() -> None:
            if was_interrupted():
                raise KeyboardInterrupt
            bar.update()

        yield advance
