"""Progress at the mouse pointer for loops over many items."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeVar

import bpy

Item = TypeVar("Item")

MANY = 1000
"""Number of items from which on the progress cursor is shown."""


def show(part: float) -> None:
    """Show the progress, 0 to 1, at the mouse pointer."""
    bpy.context.window_manager.progress_update(part)


def progress(items: Sequence[Item]) -> Iterator[Item]:
    """The items one by one, with progress at the mouse pointer if there are many."""
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
