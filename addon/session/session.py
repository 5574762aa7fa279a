"""The live tracing of each scene: its reader, its tracer and its last result. Plain Python, keyed by session id; nothing of it is saved.

A frame is read in Blender's frame handler and traced on the worker thread, while Blender draws it and evaluates the next one. `result_of`
waits for the trace; draw callbacks use `shown`, which never waits.
"""

from __future__ import annotations

import itertools
import sys
import time
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

from bpy.types import Depsgraph, Scene

from ...core.arrays import FloatArray
from ...core.modalities.modality_scene import ModalityScene
from ...core.modalities.propagation import Felt
from ...core.render.frame_result import FrameResult
from ...core.render.history import History
from ...core.scene.values import Settings
from ...core.tracer import Frame, Tracer
from ..blender import progress
from ..blender.time import seconds_of
from ..changes import revisions
from ..scene_reader.reader import SceneReader
from ..scene_reader.reading import Problem, Reading
from ..scene_reader.settings import read_settings
from ..translations.sentences import sentence
from . import modalities, worker

_PATIENCE = 2e-4
"""Seconds for which the thread that traces keeps Blender's own Python waiting; 5 ms otherwise."""


@dataclass(frozen=True, slots=True)
class Traced:
    """A frame that was traced or read from a track, complete: all that panels and viewports show is made of it.

    ``serial`` differs between any two frames. ``samples`` (l, n): up to a second of what each listener felt, until the frame.
    ``reading``: what it was traced from, None for a track. ``felt``: of the other modalities. ``errors``: in words of the core.
    """

    serial: int
    result: FrameResult
    settings: Settings
    samples: FloatArray
    reading: Reading | None = None
    felt: tuple[Felt, ...] = ()
    errors: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class _Begun:
    """A frame that is being traced: what was read of it, and the times [ms] of reading it and of Blender's evaluation."""

    serial: int
    reading: Reading
    modalities: tuple[ModalityScene, ...]
    errors: tuple[str, ...]
    read_milliseconds: float
    blender_milliseconds: float


@dataclass(slots=True)
class Session:
    """One scene being traced. ``begun`` is the frame whose trace nobody has waited for yet; after that ``result`` is what it gave.
    ``previous``: the result before. ``shown``: the last complete frame, for draw callbacks; the worker sets it."""

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
    begun: Future[Traced] | None = None
    serial: int = 0  # of the frame that was begun last
    begun_at: float = 0.0  # time.monotonic() of that
    shown: Traced | None = None
    failure: tuple[Problem, ...] = ()  # where the last frame could not be traced
    derived: dict[Any, Any] = field(default_factory=dict)  # see `derived.Derived`
    watched: str = ""  # the listener that was the active object last
    draw_milliseconds: float = 0.0  # of the last redraw of a viewport


_sessions: dict[int, Session] = {}
_begun = 0.0
_evaluating = 0.0
_serials = itertools.count(1)


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


def problems_of(scene: Scene) -> tuple[Problem, ...]:
    """What a designer should mend."""
    session = _sessions.get(scene.session_uid)
    if session is None:
        return ()
    _finish(scene, session)
    return session.problems


def shown(scene: Scene) -> Traced | None:
    """The last frame that is complete, without waiting for one that is being traced."""
    session = _sessions.get(scene.session_uid)
    return None if session is None else session.shown


def felt_in(scene: Scene) -> tuple[Felt, ...]:
    """What the last complete frame of a scene felt like, one value per modality beside vibration that is switched on."""
    traced = shown(scene)
    return () if traced is None else traced.felt


def is_behind(scene: Scene) -> bool:
    """True while a newer frame than the one `shown` is being traced."""
    session = _sessions.get(scene.session_uid)
    return session is not None and session.begun is not None and (session.shown is None or session.shown.serial != session.serial)


def shown_problems(scene: Scene) -> tuple[Problem, ...]:
    """What a designer should mend, as far as it is known without waiting."""
    session = _sessions.get(scene.session_uid)
    if session is None:
        return ()
    return session.failure if session.shown is None else _problems(session.shown)


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
    session.serial = next(_serials)
    session.shown = Traced(session.serial, result, read_settings(scene), session.history.all())
    worker.submit(_follow, session)


def clear() -> None:
    """Forget every scene."""
    worker.shut_down()
    _sessions.clear()
    revisions.mark_changed()


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
    if session.version != revisions.authored():
        session.reader.forget()
        session.version = revisions.authored()
    started = time.perf_counter()
    reading = None if session.reader.is_empty else session.reader.read(scene, depsgraph)
    if reading is None or session.reader.is_empty:
        session.reading, session.result, session.problems, session.frame, session.shown = None, None, (), None, None
        session.failure = ()
        return
    others, errors = modalities.read(scene, {item.name for item in reading.objects})
    session.reading = reading
    session.tracer.collisions.lazy = live and not others
    session.tracer.collisions.settings = reading.contact_settings
    session.tracer.collisions.impact_sources = scene.haptics.impacts
    session.tracer.collisions.impact_materials = reading.impact_materials if scene.haptics.impact_signal == "MATERIALS" else {}
    step, whole = scene.render.fps_base / scene.render.fps, scene.frame_subframe == 0
    follows = session.frame is not None and scene.frame_current == session.frame + 1
    continuous = whole and follows and step == session.frame_seconds
    session.frame, session.frame_seconds = scene.frame_current if whole else None, step
    session.serial = next(_serials)
    read_milliseconds = 1000 * (time.perf_counter() - started)
    begun = _Begun(session.serial, reading, others, errors, read_milliseconds, 1000 * _evaluating)
    session.begun_at = time.monotonic()
    session.begun = worker.submit(_step, session, begun, frame_of(scene, reading, continuous))
    worker.submit(_follow, session)


def _step(session: Session, begun: _Begun, frame: Frame) -> Traced:
    """On the worker: trace a frame. Raises ValueError that names the object where a designer's expression gives no gain."""
    patience = sys.getswitchinterval()
    sys.setswitchinterval(_PATIENCE)
    try:
        try:
            result = session.tracer.step(frame)
        except ValueError as error:
            session.tracer.reset()
            session.failure = (*begun.reading.problems, Problem("", str(error)))
            raise
        session.history.feed(result)
        felt, errors = modalities.felt_of(begun.modalities, result, frame.settings)
        result = replace(
            result,
            milliseconds={"read": begun.read_milliseconds, **result.milliseconds},
            statistics={**result.statistics, "blender_milliseconds": begun.blender_milliseconds},
        )
        samples, errors = session.history.all(), begun.errors + errors
        session.shown = Traced(begun.serial, result, frame.settings, samples, begun.reading, felt, errors)
        return session.shown
    except BaseException:
        session.shown = None
        raise
    finally:
        sys.setswitchinterval(patience)


def _follow(session: Session) -> None:
    """On the worker: compute what is shown of every frame."""
    for derived in tuple(session.derived):
        derived.follow(session)


def _finish(scene: Scene, session: Session) -> None:
    """Wait for the frame that is being traced, and keep what it gave."""
    begun, session.begun = session.begun, None
    if begun is None:
        return
    session.result = None
    started = time.perf_counter()
    try:
        traced = progress.result_of(begun)
    except ValueError:
        session.problems = session.failure
        return
    waited = 1000 * (time.perf_counter() - started)
    session.result = replace(traced.result, statistics={**traced.result.statistics, "waited_milliseconds": waited})
    session.shown = replace(traced, result=session.result)
    session.problems = _problems(traced)


def _problems(traced: Traced) -> tuple[Problem, ...]:
    """What a designer should mend of a frame, in the language of the interface."""
    read = () if traced.reading is None else traced.reading.problems
    warnings = (Problem(warning.object, sentence(warning)) for warning in traced.result.warnings)
    return (*read, *warnings, *(Problem("", error) for error in traced.errors))


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
