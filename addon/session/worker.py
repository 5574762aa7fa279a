"""The worker thread, which traces frames and computes derived values, and the timer that redraws
afterwards.

Jobs run in sequence and do not access Blender; the timer runs on Blender's main thread. `cancel`
ends a job between any two instructions of Python, so a job must own the data that it changes, or
the owner must discard it after a `Cancelled`.
"""

from __future__ import annotations

import ctypes
import math
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, TypeVar

import bpy

from ..blender.progress import show
from ..blender.time import is_playing, is_playing_anywhere
from ..changes.redraw import redraw_sidebars, redraw_viewports

Value = TypeVar("Value")

MOMENT = 0.1
"""Delay before the progress cursor [s]."""

_PROGRESS_INTERVAL = 0.5
"""Seconds between two redraws of the sidebars while a job runs."""

_INTERVAL = 0.02
"""Polling interval of the timer while the worker is busy [s]."""

SWITCH_INTERVAL = 2e-4
"""Python's switch interval [s] while a job runs, the longest time that the worker holds the GIL.
With Python's default of 5 ms the 99th percentile of redraw delays was 1.4 to 2.8 times as large
while contacts were computed (benchmarks/bench_switch_interval.py)."""


class Cancelled(BaseException):
    """The running job was cancelled. Like `SystemExit` not an Exception, so that error handlers do
    not catch it."""


@dataclass(slots=True)
class _WorkerState:
    """lock: for ``running`` and ``pending``. running: identifier of the worker thread while it is
    inside a job that may be cancelled."""

    lock: threading.Lock = field(default_factory=threading.Lock)
    running: int | None = None
    executor: ThreadPoolExecutor | None = None
    pending: int = 0  # jobs that have not ended, or whose end is not noted yet
    owes_redraw: bool = False  # a job has ended since the last redraw
    redraw_at: float = math.inf  # time.monotonic()
    progress_at: float = 0.0  # the same, of the last redraw that shows progress
    after_render: Callable[[], None] | None = None


_state = _WorkerState()


def submit(job: Callable[..., Value], *arguments: object) -> Future[Value]:
    """Queue a job, and redraw the 3D viewports and their sidebars when it has ended. Call it on the
    main thread."""
    if _state.executor is None:
        _state.executor = ThreadPoolExecutor(1, "haptic-tracing")
    with _state.lock:
        _state.pending += 1
    future: Future[Value] = _state.executor.submit(_run, job, *arguments)
    future.add_done_callback(_ended)
    _start_timer()
    return future


def _run(job: Callable[..., Value], *arguments: object) -> Value:
    """On the worker: run a job so that `cancel` can end it."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_INTERVAL)
    try:
        with _state.lock:
            _state.running = threading.get_ident()
        try:
            return job(*arguments)
        finally:
            with _state.lock:
                _state.running = None
                # A late cancellation must not affect the next job.
                _raise_in(threading.get_ident(), None)
    finally:
        sys.setswitchinterval(interval)


def _raise_in(thread: int, exception: type[BaseException] | None) -> None:
    """Raise an exception in another thread at its next instruction of Python; None takes back one
    that is not raised yet."""
    ctypes.pythonapi.PyThreadState_SetAsyncExc(
        ctypes.c_ulong(thread), None if exception is None else ctypes.py_object(exception)
    )


def cancel() -> None:
    """Drop the queued jobs, end the running one and the thread. Returns when nothing runs.
    Thread-safe.

    Futures of dropped jobs are cancelled, that of the running job has the exception `Cancelled`. It
    takes as long as the longest call of native code.
    """
    executor, _state.executor = _state.executor, None
    if executor is None:
        return
    executor.shutdown(wait=False, cancel_futures=True)
    with _state.lock:
        running, _state.running = _state.running, None  # at most once for a job
        if running is not None:
            _raise_in(running, Cancelled)
    executor.shutdown()


def end_within(seconds: float | None) -> bool:
    """Wait for all jobs, for at most ``seconds`` if given, and end the thread; returns False if a
    job takes longer, which goes on."""
    executor = _state.executor
    if executor is None:
        return True
    if not done_within(executor.submit(lambda: None), seconds):
        return False
    _state.executor = None
    executor.shutdown()
    return True


def call_after_render(resume: Callable[[], None]) -> None:
    """Call ``resume`` on the main thread after the end of rendering, if a job was queued before.
    Thread-safe."""
    _state.after_render = resume


def result_of(future: Future[Value]) -> Value:
    """Wait for a result. After `MOMENT` the mouse pointer shows progress, except while the timeline
    plays."""
    if done_within(future, MOMENT) or is_playing():
        return future.result()
    manager = bpy.context.window_manager
    manager.progress_begin(0, 1)
    begun = time.perf_counter()
    try:
        while not done_within(future, MOMENT):
            passed = time.perf_counter() - begun
            show(passed / (1 + passed))  # the duration is unknown
    finally:
        manager.progress_end()
    return future.result()


def is_interactive() -> bool:
    """Whether Blender has a user interface; background scripts wait for results."""
    return not bpy.app.background


def done_within(future: Future[Any], seconds: float | None) -> bool:
    """Wait for a job, for at most ``seconds`` if given; returns whether it has ended."""
    with suppress(TimeoutError, CancelledError):
        future.exception(seconds)
    return future.done()


def redraw_after(seconds: float) -> None:
    """Redraw after this time."""
    _state.redraw_at = time.monotonic() + seconds
    _start_timer()


def _start_timer() -> None:
    if is_interactive() and not bpy.app.timers.is_registered(
        _redraw_after_jobs
    ):  # else Blender calls no timers
        bpy.app.timers.register(_redraw_after_jobs, first_interval=_INTERVAL, persistent=True)


def shut_down() -> None:
    """Cancel all jobs and end thread and timer."""
    cancel()
    if bpy.app.timers.is_registered(_redraw_after_jobs):
        bpy.app.timers.unregister(_redraw_after_jobs)
    _state.owes_redraw, _state.redraw_at, _state.after_render = False, math.inf, None


def _ended(future: Future[Any]) -> None:
    _state.owes_redraw = True  # before the timer may find nothing pending and stop
    with _state.lock:
        _state.pending -= 1


def _redraw_after_jobs() -> float | None:
    """Redraw if a job has ended. During playback Blender redraws by itself, so redraw only after
    its end."""
    if time.monotonic() >= _state.redraw_at:
        _state.owes_redraw, _state.redraw_at = True, math.inf
    if _state.after_render is not None and not bpy.app.is_job_running("RENDER"):
        resume, _state.after_render = _state.after_render, None
        resume()
    is_idle = _state.pending == 0 and _state.after_render is None
    if _state.owes_redraw and not is_playing_anywhere():
        _state.owes_redraw = False
        redraw_viewports()
    elif not is_idle and time.monotonic() > _state.progress_at + _PROGRESS_INTERVAL:
        _state.progress_at = time.monotonic()
        redraw_sidebars()
    return (
        None if is_idle and not _state.owes_redraw and _state.redraw_at == math.inf else _INTERVAL
    )
