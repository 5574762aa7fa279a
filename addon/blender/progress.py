"""A progress bar at the mouse pointer for what takes longer than a moment."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, TypeVar

import bpy

if TYPE_CHECKING:
    from concurrent.futures import Future

Item = TypeVar("Item")

MOMENT = 0.1
"""Delay before the progress cursor [s]."""

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


def result_of(future: Future[Item]) -> Item:
    """Wait for a result; after a moment with a sign that the wait is for something, except while frames follow each other anyway."""
    screen = bpy.context.screen
    if _done_within(future, MOMENT) or (screen is not None and screen.is_animation_playing):
        return future.result()
    manager = bpy.context.window_manager
    manager.progress_begin(0, 1)
    begun = time.perf_counter()
    try:
        while not _done_within(future, MOMENT):
            passed = time.perf_counter() - begun
            show(passed / (1 + passed))  # how long it takes is not known
    finally:
        manager.progress_end()
    return future.result()


def _done_within(future: Future[Item], seconds: float) -> bool:
    try:
        future.exception(seconds)
    except TimeoutError:
        return False
    return True
