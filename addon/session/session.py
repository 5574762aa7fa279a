"""The live tracing of each scene: its reader, its tracer and its last result. Plain Python, keyed by session id; nothing of it is saved.

What is read in Blender's frame handler is traced on a thread of its own, while Blender goes on with drawing the frame and evaluating the
next one: it lets go of Python meanwhile. Whoever asks for the result waits for it. Nothing on that thread knows of Blender.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

from bpy.types import Depsgraph, Scene

from ...core.arrays import FloatArray
from ...core.render.frame_result import FrameResult
from ...core.render.history import History
from ...core.tracer import Frame, Tracer
from ..blender import progress
from ..scene_reader.reader import Problem, Reading, SceneReader, seconds_of
from ..translations.sentences import sentence
from . import modalities

_PATIENCE = 2e-4
"""Seconds for which the thread that traces keeps Blender's own Python waiting; 5 ms otherwise."""


@dataclass(frozen=True, slots=True)
class _Begun:
    """A frame that is being traced."""

    result: Future[FrameResult]
    read_milliseconds: float
    blender_milliseconds: float
    problems: tuple[Problem, ...]


@dataclass(slots=True)
class Session:
    """One scene being traced. ``begun`` is the last frame, until somebody waits for it; then ``result`` is what it gave. ``previous`` is
    what there was of the frame before."""

    reader: SceneReader = field(default_factory=SceneReader)
    tracer: Tracer = field(default_factory=Tracer)
    reading: Reading | None = None
    result: FrameResult | None = None
    previous: FrameResult | None = None
    problems: tuple[Problem, ...] = ()
    frame: int | None = None
    frame_seconds: float = 0.0
    version: int = -1
    history: History = field(default_factory=History)
    begun: _Begun | None = None
    draw_milliseconds: float = 0.0  # of the last redraw of a viewport


_sessions: dict[int, Session] = {}
_version = 0
_edits = 0
_begun = 0.0
_evaluating = 0.0
_thread: ThreadPoolExecutor | None = None


def mark_changed() -> None:
    """Something an author can change has changed, in some scene."""
    global _version
    _version += 1


def mark_edited() -> None:
    """Something in Blender was edited, that an author's settings may or may not depend on."""
    global _edits
    _edits += 1


def edits() -> int:
    """A number that changes with every edit."""
    return _version + _edits


def of(scene: Scene) -> Session:
    """The session of a scene, made at first use."""
    session = _sessions.get(scene.session_uid)
    if session is None:
        session = _sessions[scene.session_uid] = Session()
    return session


def result_of(scene: Scene) -> FrameResult | None:
    """The last frame of a scene whose tracing was begun; waits for it."""
    session = _sessions.get(scene.session_uid)
    if session is None:
        return None
    _finish(scene, session)
    return session.result


def latest_while_busy(scene: Scene) -> FrameResult | None:
    """What there was of the frame before, while the one that was begun last is still being traced; else None."""
    session = of(scene)
    return session.previous if session.begun is not None and not session.begun.result.done() else None


def problems_of(scene: Scene) -> tuple[Problem, ...]:
    """What a designer should mend."""
    session = _sessions.get(scene.session_uid)
    if session is None:
        return ()
    _finish(scene, session)
    return session.problems


@contextmanager
def drawing(scene: Scene) -> Iterator[None]:
    """What is done inside counts as drawing the scene's results."""
    started = time.perf_counter()
    try:
        yield
    finally:
        of(scene).draw_milliseconds += 1000 * (time.perf_counter() - started)


def show(scene: Scene, result: FrameResult, samples: FloatArray) -> None:
    """Keep a result that was read from a track instead of being traced, and the ``samples`` (l, n) that lead up to its end."""
    session = of(scene)
    _finish(scene, session)
    session.result, session.frame = result, None
    session.history.take(result, samples)


def clear() -> None:
    """Forget every scene."""
    global _thread
    if _thread is not None:
        _thread.shutdown()
        _thread = None
    _sessions.clear()
    modalities.forget()
    mark_changed()


def frame_begins() -> None:
    """Blender begins to evaluate a frame."""
    global _begun
    _begun = time.perf_counter()


def frame_evaluated() -> None:
    """Blender has evaluated the frame: what that took is in the statistics of the frame that is traced now."""
    global _evaluating
    _evaluating = time.perf_counter() - _begun if _begun else 0.0


def trace(scene: Scene, depsgraph: Depsgraph, live: bool = False) -> FrameResult | None:
    """Trace the scene as it stands now. See `begin`."""
    begin(scene, depsgraph, live)
    return result_of(scene)


def begin(scene: Scene, depsgraph: Depsgraph, live: bool = False) -> None:
    """Read the scene as it stands now and begin to trace it. The result is None where nothing is tagged, or where a problem forbids it.
    ``live``: for the moment only, so that contacts that no signal gets to need not be looked for."""
    session = of(scene)
    _finish(scene, session)
    session.previous = session.result
    if session.version != _version:
        session.reader.forget()
        session.version = _version
    started = time.perf_counter()
    reading = None if session.reader.is_empty else session.reader.read(scene, depsgraph)
    if reading is None or session.reader.is_empty:
        session.reading, session.result, session.problems, session.frame = None, None, (), None
        return
    read_milliseconds = 1000 * (time.perf_counter() - started)
    session.reading = reading
    others = bool(modalities.wanted_in(scene))
    session.tracer.lazy = live and not others
    session.tracer.contact_settings = reading.contact_settings
    session.tracer.impact_sources = scene.haptics.impacts
    session.tracer.impact_materials = reading.impact_materials if scene.haptics.impact_signal == "MATERIALS" else {}
    step, whole = scene.render.fps_base / scene.render.fps, scene.frame_subframe == 0
    follows = session.frame is not None and scene.frame_current == session.frame + 1
    continuous = whole and follows and step == session.frame_seconds
    session.frame, session.frame_seconds = scene.frame_current if whole else None, step
    result = _on_thread(session, frame_of(scene, reading, continuous))
    session.begun = _Begun(result, read_milliseconds, 1000 * _evaluating, reading.problems)
    if others:
        _finish(scene, session)  # they are read from the scene as it stands now


def _on_thread(session: Session, frame: Frame) -> Future[FrameResult]:
    global _thread
    if _thread is None:
        _thread = ThreadPoolExecutor(1, "haptic-tracing")
    return _thread.submit(_step, session, frame)


def _step(session: Session, frame: Frame) -> FrameResult:
    patience = sys.getswitchinterval()
    sys.setswitchinterval(_PATIENCE)
    try:
        result = session.tracer.step(frame)
        session.history.feed(result)
        return result
    finally:
        sys.setswitchinterval(patience)


def _finish(scene: Scene, session: Session) -> None:
    """Wait for the frame that is being traced, and keep what it gave."""
    begun, session.begun = session.begun, None
    if begun is None:
        return
    session.result = None
    started = time.perf_counter()
    try:
        result = progress.result_of(begun.result)
    except ValueError as error:
        session.tracer.reset()
        session.problems = (*begun.problems, Problem("", str(error)))
        return
    waited = 1000 * (time.perf_counter() - started)
    session.result = replace(
        result,
        milliseconds={"read": begun.read_milliseconds, **result.milliseconds},
        statistics={**result.statistics, "blender_milliseconds": begun.blender_milliseconds, "waited_milliseconds": waited},
    )
    session.problems = (
        begun.problems + tuple(Problem(warning.object, sentence(warning)) for warning in result.warnings) + modalities.trace(scene, result)
    )


def frame_of(scene: Scene, reading: Reading, continuous: bool) -> Frame:
    """What the tracer is told of a reading."""
    return Frame(
        number=scene.frame_current,
        time=seconds_of(scene, scene.frame_current),
        objects=reading.objects,
        sources=reading.sources,
        listeners=reading.listeners,
        settings=reading.settings,
        bodies=reading.bodies,
        transforms=reading.transforms,
        continuous=continuous,
        authored=reading.authored,
    )
