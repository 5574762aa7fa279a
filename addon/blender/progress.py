"""A progress bar at the mouse pointer for what takes longer than a moment."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeVar

import bpy

Item = TypeVar("Item")

MANY = 1000
"""Number of items from which on the progress cursor is shown."""


def show(part: float) -> None:
    """The part, 0 to 1, that is done, at the mouse pointer."""
    bpy.context.window_manager.progress_update(part)


def progress(items: Sequence[Item]) -> Iterator[Item]:
    """The items one by one, with a progress bar where they are many."""
    if len(items) < MANY:
        yield from items
        return
    manager = bpy.context.window_manager
    manager.progress_begin(0, 1)
    try:
        for number, item in enumerate(items):
            if number % 200 == 0:
                show(number / len(items))
            yield item
    finally:
        manager.progress_end()
