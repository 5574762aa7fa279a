"""Long jobs: in steps between the events of Blender's window, with a progress bar and cancelled by
ESC, or at once without a window."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, wait
from contextlib import suppress
from threading import Event, Thread
from typing import ClassVar

import bpy
from bpy.types import Context, Header, Operator, WindowManager
from bpy.types import Event as WindowEvent

from .polling import Action, Need
from .text import wrapped
from .words import TranslatedError, report_text, ui_text

BUDGET = 0.1
"""Seconds of work between two rounds of events."""
WAIT = 0.02
"""Seconds of waiting for the writing thread between two rounds of events."""
LINE = 60
"""Characters per line of a question."""

Report = tuple[set[str], str]


class Cancelled(Exception):
    """Raised when a job was cancelled."""


class Job:
    """Steps in Blender's thread, then writing in another: ``work`` yields ``total`` times,
    ``finish`` returns the reports.

    ``finish`` gets the job, for `progress` and `ask`, and does not access Blender's data. Nothing
    is written before it, so that a cancelled job leaves no files.
    """

    in_window: ClassVar[Job | None] = None
    """The job that runs in the window."""

    def __init__(
        self,
        label: str,
        total: int,
        work: Iterator[object],
        finish: Callable[[Job], list[Report]],
    ) -> None:
        """Prepare a job; nothing is run.

        Args:
            label: for the user.
            total: number of steps of ``work``, for the progress.
            work: the steps in Blender's thread. Where it changes Blender's data, it pushes an undo
                step at once: an undo after a change without a step may leave pointers to what is
                freed, and the job may end there, cancelled, by an error or with the window.
            finish: writes the files in another thread, and returns reports.
        """
        self.label = label
        self.total = max(total, 1)
        self.done = 0
        self.asks = False
        """Whether there is a window in which a question can be answered."""
        self.question: tuple[str, ...] = ()
        """Lines of the question that waits for an answer."""
        self._work, self._finish = work, finish
        self._writing: Future[list[Report]] | None = None
        self._written = 0.0
        self._cancelled = Event()
        self._answered = Event()
        self._consent = False

    @property
    def factor(self) -> float:
        """Progress of the steps or, after the last one, of the writing, 0 to 1."""
        return min(self.done / self.total, 1.0) if self._writing is None else self._written

    @property
    def state(self) -> str:
        """Description of the current activity."""
        if self._writing is None:
            return ui_text(
                "{}: {} of {}", ui_text(self.label), min(self.done, self.total), self.total
            )
        return ui_text("Writing")

    def advance(self, seconds: float) -> list[Report] | None:
        """Work for this many seconds, at least one step. Returns None if there is more to do.

        Raises the exceptions of the work, and `Cancelled`.
        """
        if self._writing is None:
            if self._cancelled.is_set():
                raise Cancelled
            until = time.perf_counter() + seconds
            for _ in self._work:
                self.done += 1
                if time.perf_counter() >= until:
                    return None
            self._writing = Future()
            Thread(
                target=self._write, args=(self._writing,), name="haptics writing", daemon=True
            ).start()
        wait([self._writing], WAIT)
        return self._writing.result() if self._writing.done() else None

    def _write(self, result: Future[list[Report]]) -> None:
        try:
            result.set_result(self._finish(self))
        except BaseException as error:  # raised again in Blender's thread
            result.set_exception(error)

    def progress(self, factor: float) -> None:
        """Set the progress of the writing, 0 to 1. Raises `Cancelled`."""
        if self._cancelled.is_set():
            raise Cancelled
        self._written = factor

    def ask(self, question: Iterable[str]) -> bool:
        """Ask a question of several lines and wait for the answer; True without a user."""
        if not self.asks:
            return True
        self._answered.clear()
        if self._cancelled.is_set():
            return False
        self.question = tuple(question)
        self._answered.wait()
        return self._consent

    def answer(self, consent: bool) -> None:
        """Answer the pending question."""
        self.question = ()
        self._consent = consent
        self._answered.set()

    def cancel(self) -> None:
        """Cancel, without waiting for the writing; the work restores its changes."""
        self._cancelled.set()
        self.answer(False)
        close = getattr(self._work, "close", None)
        if close is not None:
            with suppress(ReferenceError):  # the scene may have been removed
                close()


IDLE = Need(
    lambda context: Job.in_window is None, "Wait for the running job, or press Esc to cancel it"
)
"""That no job runs in the window."""


def run(operator: Operator, context: Context, job: Job) -> set[str]:
    """Run a job for an operator: in steps if there is a window, else at once. Raises what the job
    raises, and ValueError while another one runs."""
    if (
        operator.options.is_invoke
        and not bpy.app.background
        and context.window is not None
        and job.total > 1
    ):
        if Job.in_window is not None:
            raise TranslatedError("{} is not done yet", Job.in_window.label)
        job.asks = True
        Job.in_window = job
        bpy.app.timers.register(_start, first_interval=0.05)  # the file browser closes first
        return {"FINISHED"}
    manager = context.window_manager
    manager.progress_begin(0, job.total)
    try:
        while (reports := job.advance(BUDGET)) is None:
            manager.progress_update(job.done)
    finally:
        manager.progress_end()
        job.cancel()
    for kind, text in reports:
        operator.report(kind, text)
    return {"FINISHED"}


def _start() -> None:
    """Start the waiting job in Blender's first window."""
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        bpy.ops.haptic.run_job("INVOKE_DEFAULT")


class HAPTIC_OT_run_job(Action):
    """Step through the frames; ESC cancels"""

    bl_label = "Haptics"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return Job.in_window is not None

    def invoke(self, context: Context, event: WindowEvent) -> set[str]:
        self._asked = False
        self._timer = context.window_manager.event_timer_add(0.01, window=context.window)
        context.window_manager.modal_handler_add(self)
        context.workspace.status_text_set(draw_status)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: WindowEvent) -> set[str]:
        assert Job.in_window is not None
        if event.type == "ESC":
            Job.in_window.cancel()
        elif event.type != "TIMER":
            return {"RUNNING_MODAL"}  # blocks all other events while the frames are stepped
        if Job.in_window.question:
            if not self._asked:
                self._asked = True
                bpy.ops.haptic.replace_files("INVOKE_DEFAULT")
            return {"PASS_THROUGH"}
        try:
            reports = Job.in_window.advance(BUDGET)
        except BaseException as error:
            self.cancel(context)
            if not isinstance(error, (Cancelled, ValueError, OSError)):
                raise
            cancelled = {"WARNING"}, report_text("Cancelled: nothing was written")
            self.report(*(cancelled if isinstance(error, Cancelled) else ({"ERROR"}, str(error))))
            return {"CANCELLED"}
        context.workspace.status_text_set(draw_status)  # draws the status bar again
        _redraw(context.window_manager)
        if reports is None:
            return {"RUNNING_MODAL"}
        self.cancel(context)
        for kind, text in reports:
            self.report(kind, text)
        return {"FINISHED"}

    def cancel(self, context: Context) -> None:
        """Clean up after the job; also called by Blender when the window closes."""
        _cancel()
        context.window_manager.event_timer_remove(self._timer)
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        _redraw(context.window_manager)


class HAPTIC_OT_replace_files(Action):
    """Replace files"""

    bl_label = "Replace Files?"
    bl_options = {"INTERNAL"}

    def invoke(self, context: Context, event: WindowEvent) -> set[str]:
        return context.window_manager.invoke_props_dialog(self, width=420, confirm_text="Replace")

    def draw(self, context: Context) -> None:
        column = self.layout.column(align=True)
        for text in Job.in_window.question if Job.in_window is not None else ():
            for line in wrapped(text, LINE):
                column.label(text=line)

    def apply(self, context: Context) -> None:
        if Job.in_window is not None:
            Job.in_window.answer(True)

    def cancel(self, context: Context) -> None:
        if Job.in_window is not None:
            Job.in_window.answer(False)


def draw_status(header: Header, context: Context) -> None:
    """The status bar of Blender's window."""
    if Job.in_window is not None:
        row = header.layout.row()
        row.label(text="Cancel", icon="EVENT_ESC")
        bar = row.row()
        bar.ui_units_x = 16
        bar.progress(factor=Job.in_window.factor, text=Job.in_window.state)


def draw_running(layout: bpy.types.UILayout) -> bool:
    """Draw the progress of the job that runs in the window. Returns False if there is none."""
    if Job.in_window is None:
        return False
    layout.progress(factor=Job.in_window.factor, text=Job.in_window.state)
    layout.label(text="Press Esc to cancel")
    return True


def _redraw(manager: WindowManager) -> None:
    for window in manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def stop() -> None:
    """Cancel the running job, because the add-on is disabled."""
    if bpy.app.timers.is_registered(_start):
        bpy.app.timers.unregister(_start)
    _cancel()


def _cancel() -> None:
    if Job.in_window is not None:
        Job.in_window.cancel()
        Job.in_window = None
