"""Values computed on the worker thread for draw callbacks, which must neither compute nor wait."""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic, TypeVar

from bpy.types import Scene

from ...core.frozen import frozen
from ..blender.time import is_playing
from . import sessions, worker

Choice = TypeVar("Choice", bound=Hashable)
Value = TypeVar("Value")

_SHOWN_SECONDS = 1.0
"""Time after its last draw for which a value counts as shown [s]."""
_HEARD_SECONDS = 3.0
"""Time after the last draw of a value made of samples for which samples are rendered [s]: longer
than a slow frame."""
_BRIEF = 0.01
"""Computing time [s] up to which a value is computed immediately, also during playback."""
_REST = 0.3
"""Time [s] without a new frame after which slower values are computed."""


@frozen
class Latest(Generic[Value]):
    """The last computed value. ``is_current``: it belongs to the shown frame, and no newer one is
    pending."""

    value: Value
    is_current: bool


@frozen
class _Computed(Generic[Value]):
    key: Hashable
    value: Value
    seconds: float


class Background(Generic[Value]):
    """A value that depends on a key, computed once per key. Draw callbacks read it on the main
    thread, the worker writes it."""

    def __init__(self) -> None:
        self.shown = 0.0  # time.monotonic() of the last draw
        self.choice: Any = None  # of a `Derived`
        self._wanted: tuple[Hashable, Callable[[Value | None], Value]] | None = None
        self._is_queued = False
        self._computed: _Computed[Value] | None = None
        self._error: Exception | None = None

    @property
    def is_brief(self) -> bool:
        """True if the last computation was fast."""
        return self._computed is not None and self._computed.seconds <= _BRIEF

    def latest(
        self, key: Hashable, compute: Callable[[Value | None], Value], *, may_start: bool = True
    ) -> Latest[Value] | None:
        """The last value, without waiting; None before there is one.

        Args:
            key: the values that the result depends on.
            compute: makes the value of ``key`` from the one before, on the worker thread; it must
                not access Blender.
            may_start: False keeps the last value although the key has changed.
        """
        self.shown = time.monotonic()
        error, self._error = self._error, None
        if error is not None:
            raise error
        computed = self._computed
        is_current = computed is not None and computed.key == key
        if not is_current and may_start:
            self.want(key, compute)
            if not self._is_queued:
                self._is_queued = True
                worker.submit(self.update).add_done_callback(self._done)
        return None if computed is None else Latest(computed.value, is_current)

    def want(self, key: Hashable, compute: Callable[[Value | None], Value]) -> None:
        """Compute this with the next `update`."""
        self._wanted = key, compute

    def _done(self, job: Future[None]) -> None:
        """Called at the end of a job: queue another one after a cancellation."""
        if job.cancelled() or job.exception() is not None:
            self._is_queued = False

    def update(self) -> None:
        """Compute the requested value unless it exists; called on the worker."""
        self._is_queued = False  # later requests are computed by another job
        if self._wanted is None:
            return
        (key, compute), before = self._wanted, self._computed
        if before is not None and before.key == key:
            return
        started = time.perf_counter()
        try:
            value = compute(None if before is None else before.value)
        except Exception as error:
            self._error = error  # raised at the next draw, where Blender prints it
        else:
            self._computed = _Computed(key, value, time.perf_counter() - started)


@dataclass(frozen=True, eq=False)
class Derived(Generic[Choice, Value]):
    """A value of each traced frame of a scene, computed once per frame and choice, and only while
    it is drawn.

    Args:
        compute: makes the value of a frame, a choice of the user and the value before, on the
            worker thread; it must not access Blender.
        every_frame: compute directly after each frame is traced. Otherwise slow values are computed
            when no more frames follow.
        hears: it is computed from samples, which are therefore rendered while it is shown.
    """

    compute: Callable[[sessions.Traced, Choice, Value | None], Value]
    every_frame: bool = False
    hears: bool = False

    def latest(self, scene: Scene, choice: Choice) -> Latest[Value] | None:
        """The last value, without waiting; None before there is one, or if nothing is traced."""
        own = sessions.known(scene)
        if own is None or own.shown is None:
            if own is not None:
                own.derived.pop(self, None)
            return None
        traced = own.shown
        background = own.derived.setdefault(self, Background())
        background.choice = choice
        key = traced.serial, choice
        compute = partial(self.compute, traced, choice)
        may_start = self.every_frame or background.is_brief or _no_frame_follows(own)
        return background.latest(key, compute, may_start=may_start)

    def follow(self, own: sessions.Session) -> None:
        """Compute the value of the frame that has just been traced if it is shown; called on the
        worker."""
        background = own.derived.get(self)
        traced = own.shown
        if (
            not self.every_frame
            or background is None
            or traced is None
            or time.monotonic() - background.shown > _SHOWN_SECONDS
        ):
            return
        choice = background.choice
        background.want((traced.serial, choice), partial(self.compute, traced, choice))
        background.update()


def shows_samples(own: sessions.Session) -> bool:
    """Whether a value is shown that is computed from samples, which must then be rendered."""
    since = time.monotonic() - _HEARD_SECONDS
    return any(
        derived.hears and background.shown > since for derived, background in own.derived.items()
    )


def _no_frame_follows(own: sessions.Session) -> bool:
    """True if no further frames follow: the timeline does not play, and there was no recent
    edit."""
    if is_playing():
        return False
    begun_at = 0.0 if own.request is None else own.request.begun_at
    rested = time.monotonic() - begun_at
    if rested < _REST:
        worker.redraw_after(_REST - rested)
        return False
    return True
