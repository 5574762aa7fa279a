"""Values computed from traced frames on the worker thread, for draw callbacks that must neither compute nor wait."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import bpy
from bpy.types import Scene

from . import session, worker

Choice = TypeVar("Choice")
Value = TypeVar("Value")

_SHOWN_SECONDS = 1.0
"""A value counts as shown for so long after it was drawn."""
_BRIEF = 0.01
"""Computing times [s] up to which a value is computed for every frame while the timeline plays."""

Computation = Callable[["session.Traced", Choice, Value | None], Value]
"""Makes a value of a traced frame, a choice of the user, and the value before."""


@dataclass(frozen=True, slots=True)
class _Computed(Generic[Choice, Value]):
    serial: int  # of the traced frame
    choice: Choice
    value: Value
    seconds: float


@dataclass(slots=True)
class _State(Generic[Choice, Value]):
    """What is known of one scene. Draw callbacks write ``choice`` and ``shown``, the worker writes ``computed`` and ``error``."""

    choice: Choice
    shown: float = 0.0  # time.monotonic() of the last draw
    is_queued: bool = False
    computed: _Computed[Choice, Value] | None = None
    error: Exception | None = None


@dataclass(frozen=True, slots=True)
class Latest(Generic[Value]):
    """The last value that was computed. ``is_current``: it is of the frame and the choice that are shown now."""

    value: Value
    is_current: bool


class Derived(Generic[Choice, Value]):
    """A value of each traced frame of a scene, computed once per frame and choice, only while it is drawn.

    Args:
        compute: runs on the worker thread and must not touch Blender.
        every_frame: compute right after each frame is traced. Else, while the timeline plays, only where computing is brief.
    """

    def __init__(self, compute: Computation[Choice, Value], every_frame: bool = False) -> None:
        self._compute = compute
        self._every_frame = every_frame

    def latest(self, scene: Scene, choice: Choice) -> Latest[Value] | None:
        """The last value, without waiting; None before there is one. Where it is not current, a new one is computed on the worker."""
        traced, own = session.shown(scene), session.of(scene)
        if traced is None:
            own.derived.pop(self, None)
            return None
        state = own.derived.get(self)
        if state is None:
            state = own.derived[self] = _State(choice)
        state.choice, state.shown = choice, time.monotonic()
        error, state.error = state.error, None
        if error is not None:
            raise error
        computed = state.computed
        is_current = computed is not None and (computed.serial, computed.choice) == (traced.serial, choice)
        if not is_current and not state.is_queued and not self._waits_for_pause(computed):
            state.is_queued = True
            worker.submit(self._update, own, state)
        return None if computed is None else Latest(computed.value, is_current)

    def follow(self, own: session.Session) -> None:
        """On the worker: compute the value of the frame that has just been traced, where it is shown."""
        state = own.derived.get(self)
        if state is not None and self._every_frame and time.monotonic() - state.shown < _SHOWN_SECONDS:
            self._update(own, state)

    def _waits_for_pause(self, computed: _Computed[Choice, Value] | None) -> bool:
        if self._every_frame or computed is None or computed.seconds <= _BRIEF:
            return False
        screen = bpy.context.screen
        return screen is not None and screen.is_animation_playing

    def _update(self, own: session.Session, state: _State[Choice, Value]) -> None:
        state.is_queued = False  # what is chosen from here on is computed by another job
        traced, choice, before = own.shown, state.choice, state.computed
        if traced is None or (before is not None and (before.serial, before.choice) == (traced.serial, choice)):
            return
        started = time.perf_counter()
        try:
            value = self._compute(traced, choice, None if before is None else before.value)
        except Exception as error:
            state.error = error  # raised at the next draw, where Blender prints it
            return
        state.computed = _Computed(traced.serial, choice, value, time.perf_counter() - started)
