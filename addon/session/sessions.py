"""The tracing sessions of all scenes, and their last complete frames, which panels and draw
callbacks read without waiting.

Keyed by the scene's session id; not saved. Independent of the core, because handlers use it in
every scene.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import count
from typing import TYPE_CHECKING, Any

import bpy
from bpy.types import Depsgraph, Scene

from ...core.frozen import frozen
from ..scene_reader.problem import Problem
from ..translations.sentences import sentence

if TYPE_CHECKING:
    from concurrent.futures import Future

    from ...core.arrays import FloatArray
    from ...core.render.frame_result import FrameResult
    from ...core.render.history import History
    from ...core.scene.values import Settings
    from ...core.tracer import Frame, Tracer
    from ..scene_reader.evaluation import Evaluation
    from ..scene_reader.reader import SceneReader
    from ..scene_reader.reading import Reading


@frozen
class Traced:
    """A complete frame, traced or read from a track, from which panels and viewports derive
    everything they show.

    ``samples`` (l, n): the last samples of each listener, up to a second. ``reading``: the input of
    the trace, None for a track. ``paths``: the connections kept in a track, see `HapticTrack`.
    ``serial`` differs between any two frames.
    """

    result: FrameResult
    settings: Settings
    samples: FloatArray
    reading: Reading | None = None
    paths: FloatArray | None = None
    serial: int = field(init=False, default_factory=count(1).__next__)


@frozen
class TraceRequest:
    """What the worker is asked to trace.

    Attributes:
        frame: input of the tracer.
        reading: the scene in that frame.
        read_milliseconds: time of reading.
        statistics: times of Blender's evaluation and of waiting for the frame before [ms].
        begun_at: time.monotonic() when it was begun.
    """

    frame: Frame
    reading: Reading
    read_milliseconds: float
    statistics: dict[str, float]
    begun_at: float


@dataclass(slots=True)
class Watched:
    """The listener that was the ``active`` object last, and the one that had the highest level when
    something was felt last; "" before."""

    active: str = ""
    strongest: str = ""


@dataclass(slots=True)
class Session:
    """One scene that is traced, frame by frame.

    A frame is begun in Blender's thread, traced by the worker, and finished in Blender's thread by
    whoever needs its result. Until then it is ``begun``; afterwards ``result`` is its result, and
    ``previous`` the one before. ``shown``, the last complete frame, is set by the worker for draw
    callbacks.

    Attributes:
        reader, tracer, history: its stages.
        request: that was begun last; None before, and while there is nothing to trace.
        begun: its trace, until it is finished.
        is_interrupted: the trace was cancelled and is to be repeated.
        last: number and duration [s] of the frame begun last, which the next one may follow; None
            between two frames.
        result, previous, shown: see above.
        failure: the cause and other problems of the last frame that could not be traced.
        waited_milliseconds: for the trace of the last frame that was waited for.
        is_asked: a script wanted the last result, or it followed no other: samples are rendered.
        evaluation: the changes that were noted last.
        postponed: begins the trace of a frame that handlers of other add-ons may still change.
        version: revision of the authored values that were read last.
        motion: checksum of the causes of the impacts that the tracer stores.
        derived: see `derived.Derived`.
        watched: which listener is.
    """

    reader: SceneReader
    tracer: Tracer
    history: History
    request: TraceRequest | None = None
    begun: Future[Traced] | None = None
    is_interrupted: bool = False
    last: tuple[int, float] | None = None
    result: FrameResult | None = None
    previous: FrameResult | None = None
    shown: Traced | None = None
    failure: tuple[Problem, ...] = ()
    waited_milliseconds: float = 0.0
    is_asked: bool = False
    evaluation: Evaluation | None = None
    postponed: Callable[[Scene, Depsgraph], None] | None = None
    version: int = -1
    motion: str | None = None
    derived: dict[Any, Any] = field(default_factory=dict)
    watched: Watched = field(default_factory=Watched)

    @property
    def reading(self) -> Reading | None:
        """The scene in the frame that was begun last."""
        return None if self.request is None else self.request.reading


@dataclass(slots=True)
class _SessionsState:
    """The sessions by scene, and when Blender began to evaluate the current frame and how long that
    took [s]."""

    sessions: dict[int, Session] = field(default_factory=dict)
    evaluation_began: float = 0.0
    evaluation_seconds: float = 0.0


_state = _SessionsState()


def known(scene: Scene) -> Session | None:
    """The session of a scene; None before it is first traced."""
    return _state.sessions.get(scene.session_uid)


def add(scene: Scene, session: Session) -> None:
    """Keep the session of a scene, and drop those of scenes that were deleted."""
    for gone in _state.sessions.keys() - {other.session_uid for other in bpy.data.scenes}:
        del _state.sessions[gone]
    _state.sessions[scene.session_uid] = session


def every() -> tuple[Session, ...]:
    """The sessions of all scenes."""
    return tuple(_state.sessions.values())


def clear() -> None:
    """Drop all sessions."""
    _state.sessions.clear()


def evaluation_begins() -> None:
    """Record that Blender begins to evaluate a frame."""
    _state.evaluation_began = time.perf_counter()


def evaluation_ends() -> None:
    """Record that Blender has evaluated the frame; the duration becomes part of the statistics of
    its trace."""
    _state.evaluation_seconds = (
        time.perf_counter() - _state.evaluation_began if _state.evaluation_began else 0.0
    )


def evaluation_seconds() -> float:
    """Duration of Blender's evaluation of the current frame [s]."""
    return _state.evaluation_seconds


def shown(scene: Scene) -> Traced | None:
    """The last complete frame, without waiting for a running trace."""
    session = known(scene)
    return None if session is None else session.shown


def is_begun(scene: Scene) -> bool:
    """True if a frame was traced, or is being traced, also if undo has dropped its result."""
    session = known(scene)
    return session is not None and session.request is not None


def is_behind(scene: Scene) -> bool:
    """True while a newer frame than the one `shown` is being traced."""
    session = known(scene)
    return session is not None and session.begun is not None and not session.begun.done()


def seconds_behind(scene: Scene) -> float:
    """For how long a newer frame than the one shown has been traced; 0 if there is none."""
    session = known(scene)
    if session is None or session.request is None or not is_behind(scene):
        return 0.0
    return time.monotonic() - session.request.begun_at


def shown_problems(scene: Scene) -> tuple[Problem, ...]:
    """The problems of a scene that are known without waiting."""
    session = known(scene)
    if session is None:
        return ()
    return session.failure if session.shown is None else problems_in(session.shown)


def problems_in(traced: Traced) -> tuple[Problem, ...]:
    """The problems of a frame, in the language of the interface."""
    read = () if traced.reading is None else traced.reading.problems
    warnings = (Problem(warning.object, sentence(warning)) for warning in traced.result.warnings)
    return (*read, *warnings)
