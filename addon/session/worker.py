"""The worker thread, which traces frames and computes what is shown of them, and the timer that redraws when it has finished.

Jobs run one after the other. None of them touches Blender; the timer runs on Blender's main thread.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from typing import Any, TypeVar

import bpy

from ..blender.playing import is_playing
from ..blender.progress import show
from ..changes.redraw import redraw_viewports

Value = TypeVar("Value")

_MOMENT = 0.1
"""Delay before the progress cursor [s]."""

_INTERVAL = 0.02
"""Seconds between two looks at the worker while it has something to do."""


@dataclass(slots=True)
class _State:
    executor: ThreadPoolExecutor | None = None
    last: Future[Any] | None = None  # the job that was queued last
    owes_redraw: bool = False  # a job has ended since the last redraw
    redraw_at: float = math.inf  # time.monotonic()


_state = _State()


def submit(job: Callable[..., Value], *arguments: object) -> Future[Value]:
    """Queue a job, and redraw the 3D viewports and their sidebars when it has ended. Call it on the main thread."""
    if _state.executor is None:
        _state.executor = ThreadPoolExecutor(1, "haptic-tracing")
    future = _state.last = _state.executor.submit(job, *arguments)
    future.add_done_callback(_ended)
    _start_timer()
    return future


def result_of(future: Future[Value]) -> Value:
    """Wait for a result. After `_MOMENT` the mouse pointer shows progress, except while the timeline plays."""
    if _done_within(future, _MOMENT) or is_playing():
        return future.result()
    manager = bpy.context.window_manager
    manager.progress_begin(0, 1)
    begun = time.perf_counter()
    try:
        while not _done_within(future, _MOMENT):
            passed = time.perf_counter() - begun
            show(passed / (1 + passed))  # how long it takes is not known
    finally:
        manager.progress_end()
    return future.result()


def _done_within(future: Future[Any], seconds: float) -> bool:
    return bool(wait((future,), seconds).done)


def redraw_after(seconds: float) -> None:
    """Redraw once so much time has passed."""
    _state.redraw_at = time.monotonic() + seconds
    _start_timer()


def _start_timer() -> None:
    if not bpy.app.timers.is_registered(_look):
        bpy.app.timers.register(_look, first_interval=_INTERVAL, persistent=True)


def shut_down() -> None:
    """Drop the queued jobs, wait for the running one and end the thread."""
    executor, _state.executor = _state.executor, None
    if executor is not None:
        executor.shutdown(cancel_futures=True)
    if bpy.app.timers.is_registered(_look):
        bpy.app.timers.unregister(_look)
    _state.last, _state.owes_redraw, _state.redraw_at = None, False, math.inf


def _ended(future: Future[Any]) -> None:
    _state.owes_redraw = True


def _look() -> float | None:
    """Redraw where a job has ended. While the timeline plays Blender redraws by itself: then only once it has stopped."""
    if time.monotonic() >= _state.redraw_at:
        _state.owes_redraw, _state.redraw_at = True, math.inf
    is_idle = _state.last is None or _state.last.done()
    if _state.owes_redraw and not any(window.screen.is_animation_playing for window in bpy.context.window_manager.windows):
        _state.owes_redraw = False
        redraw_viewports()
    return None if is_idle and not _state.owes_redraw and _state.redraw_at == math.inf else _INTERVAL
