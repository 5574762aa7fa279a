"""A progress bar at the mouse pointer for what takes longer than a moment."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeVar

import bpy

Item = TypeVar("Item")

MANY = 1000
"""Fewer items than these are done in less than the tenth of a second that nobody notices."""


def progress(items: Sequence[Item]) -> Iterator[Item]:
    """The items one by one, with a progress bar where they are many."""
    if len(items) < MANY:
        yield from items
        return
    manager = bpy.context.window_manager
    manager.progress_begin(0, len(items))
    try:
        for number, item in enumerate(items):
            if number % 200 == 0:
                manager.progress_update(number)
            yield item
    finally:
        manager.progress_end()
