"""Long work, in steps between the events of Blender's window with a progress bar, cancelled by ESC, or all at once without a window."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import bpy
from bpy.types import Context, Event, Header, Operator, WindowManager

_rpt = bpy.app.translations.pgettext_rpt

BUDGET = 0.1
"""Seconds of work between two rounds of events."""

Report = tuple[set[str], str]


class Job:
    """``work`` yields after every one of ``total`` steps; ``finish`` is called after the last and returns what to report.

    Nothing is written before ``finish``, so that a cancelled job leaves no files.
    """

    def __init__(self, label: str, total: int, work: Iterator[object], finish: Callable[[], list[Report]]) -> None:
        self.label, self.total, self.done = label, max(total, 1), 0
        self._work, self._finish = work, finish

    @property
    def factor(self) -> float:
        """How much is done, 0 to 1."""
        return min(self.done / self.total, 1.0)

    def advance(self, seconds: float) -> list[Report] | None:
        """Work for this many seconds, at least one step. Returns None where there is more to do. Raises what the work raises."""
        until = time.perf_counter() + seconds
        for _ in self._work:
            self.done += 1
            if time.perf_counter() >= until:
                return None
        return self._finish()

    def cancel(self) -> None:
        """Cancel; the work restores what it changed."""
        close = getattr(self._work, "close", None)
        if close is not None:
            close()


@dataclass(slots=True)
class _State:
    """The job that runs in the window."""

    running: Job | None = None


_state = _State()


def running() -> Job | None:
    """The job that runs in the window."""
    return _state.running


def run(operator: Operator, context: Context, job: Job) -> set[str]:
    """Run a job for an operator: in steps where a user waits at a window, else at once. ValueError and OSError are reported."""
    if operator.options.is_invoke and not bpy.app.background and context.window is not None and job.total > 1:
        if _state.running is not None:
            operator.report({"ERROR"}, _rpt("{} is not done yet").format(_state.running.label))
            return {"CANCELLED"}
        _state.running = job
        bpy.app.timers.register(_start, first_interval=0.05)  # the file browser closes first
        return {"FINISHED"}
    manager = context.window_manager
    manager.progress_begin(0, job.total)
    try:
        while (reports := job.advance(BUDGET)) is None:
            manager.progress_update(job.done)
    except (ValueError, OSError) as error:
        operator.report({"ERROR"}, str(error))
        return {"CANCELLED"}
    finally:
        manager.progress_end()
        job.cancel()
    for kind, text in reports:
        operator.report(kind, text)
    return {"FINISHED"}


def _start() -> None:
    """Start the waiting job in Blender's first window."""
    if _state.running is None:
        return
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window):
        bpy.ops.haptic.run_job("INVOKE_DEFAULT")


class HAPTIC_OT_run_job(Operator):
    """Step through the frames; ESC cancels"""

    bl_idname = "haptic.run_job"
    bl_label = "Haptics"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return _state.running is not None

    def invoke(self, context: Context, event: Event) -> set[str]:
        self._timer = context.window_manager.event_timer_add(0.01, window=context.window)
        context.window_manager.modal_handler_add(self)
        context.workspace.status_text_set(draw_status)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        assert _state.running is not None
        if event.type == "ESC":
            self.cancel(context)
            self.report({"WARNING"}, _rpt("Cancelled: nothing was written"))
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}  # nothing else happens while the frames are stepped
        try:
            reports = _state.running.advance(BUDGET)
        except (ValueError, OSError) as error:
            self.cancel(context)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        except BaseException:
            self.cancel(context)
            raise
        context.workspace.status_text_set(draw_status)  # draws the status bar again
        _redraw(context.window_manager)
        if reports is None:
            return {"RUNNING_MODAL"}
        self.cancel(context)
        for kind, text in reports:
            self.report(kind, text)
        return {"FINISHED"}

    def cancel(self, context: Context) -> None:
        """End the job, in whatever way; also called by Blender when the window closes."""
        if _state.running is not None:
            _state.running.cancel()
            _state.running = None
        context.window_manager.event_timer_remove(self._timer)
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        _redraw(context.window_manager)


def draw_status(header: Header, context: Context) -> None:
    """The status bar of Blender's window."""
    if _state.running is not None:
        row = header.layout.row()
        row.label(text="Cancel", icon="EVENT_ESC")
        bar = row.row()
        bar.ui_units_x = 16
        draw_progress(bar, _state.running)


def draw_progress(layout: bpy.types.UILayout, job: Job) -> None:
    """Draw the progress bar."""
    layout.progress(factor=job.factor, text=f"{job.label}: {job.done} of {job.total} frames")


def _redraw(manager: WindowManager) -> None:
    for window in manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def stop() -> None:
    """Cancel the running job, as the add-on is disabled."""
    if bpy.app.timers.is_registered(_start):
        bpy.app.timers.unregister(_start)
    if _state.running is not None:
        _state.running.cancel()
        _state.running = None


CLASSES = (HAPTIC_OT_run_job,)
