"""Traces scenes: a frame is read in Blender's frame handler and traced on the worker thread, while
Blender draws it and evaluates the next one. `result_of` waits for the trace; draw callbacks use
`sessions.shown`, which never waits.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from dataclasses import replace

import bpy
import numpy as np
from bpy.types import Depsgraph, Scene

from ...core.arrays import FloatArray
from ...core.contacts.known_motion import KnownMotion
from ...core.events.frame import EXACT_FRAMES
from ...core.render.frame_result import FrameResult
from ...core.render.history import History
from ...core.render.mixdown import with_block
from ...core.tracer import Frame, Tracer
from ..blender.compatibility import THREADS_ENDANGER_SCRIPTS
from ..blender.handlers import are_frames_shared
from ..blender.time import Moment, frame_seconds, is_playing, seconds_of
from ..changes import revisions
from ..changes.events import file_changed, mode_changed
from ..changes.suspension import is_stepped
from ..scene_reader.digest import motion_of
from ..scene_reader.evaluation import Evaluation
from ..scene_reader.kept_impacts import impacts_from_text, text_of_impacts
from ..scene_reader.known_motion import known_motion
from ..scene_reader.present import traced_layer
from ..scene_reader.problem import Problem
from ..scene_reader.reader import SceneReader
from ..scene_reader.reading import Reading
from ..scene_reader.set_elsewhere import set_elsewhere
from ..scene_reader.settings import read_settings
from . import sessions, worker
from .derived import shows_samples
from .sessions import Session, Traced, TraceRequest, known

_LONGEST_STEP = 0.25
"""Longest time between two frames that playback shows of which the later one follows [s]."""


def of(scene: Scene) -> Session:
    """The session of a scene, created at first use."""
    session = known(scene)
    if session is None:
        session = Session(SceneReader(), Tracer(), History())
        sessions.add(scene, session)
    return session


def result_of(scene: Scene) -> FrameResult | None:
    """The result of the last frame of a scene, after waiting for its trace."""
    session = known(scene)
    if session is None:
        return None
    read_postponed()
    _finish(session)
    session.is_asked = True
    if session.result is not None:
        session.result = with_block(session.result)
    return session.result


def problems_of(scene: Scene) -> tuple[Problem, ...]:
    """The problems of a scene."""
    session = known(scene)
    if session is None:
        return ()
    read_postponed()
    _finish(session)
    return sessions.shown_problems(scene)


def show(
    scene: Scene, result: FrameResult, samples: FloatArray, paths: FloatArray | None = None
) -> None:
    """Set a result from a track, with the ``samples`` (l, n) up to its end, and its ``paths``."""
    session = of(scene)
    _finish(session)
    session.result, session.last = result, None
    session.history.take(result, samples)
    session.shown = Traced(result, read_settings(scene), session.history.all(), paths=paths)
    worker.submit(_follow, session)


def postpone(scene: Scene, begin: Callable[[Scene, Depsgraph], None]) -> None:
    """Let ``begin`` read and begin to trace a frame when Blender has finished it: when its result
    is asked for, by `read_postponed`, or before the next frame."""
    of(scene).postponed = begin


def read_postponed() -> None:
    """Begin to trace the frames that were postponed."""
    for scene in bpy.data.scenes:
        session = known(scene)
        if session is not None and session.postponed is not None:
            session.postponed(scene, traced_layer(scene).depsgraph)


def recheck_shapes() -> None:
    """Make every scene compare all meshes at its next reading."""
    for session in sessions.every():
        session.reader.recheck_shapes()


def note(depsgraph: Depsgraph, names_all: bool = False) -> Evaluation:
    """Make every scene compare what an evaluation may have changed at its next reading; see
    `Evaluation.of`. Of a frame that is set again, scripts may have edited anything; and of an edit
    of a haptic property, Blender names the object and its children as if they were moved."""
    shown = known(depsgraph.scene)
    moves = True
    if shown is not None:
        names_all &= shown.last is None or shown.last[0] != depsgraph.scene.frame_current
        moves = shown.version == revisions.authored()
    evaluation = Evaluation.of(depsgraph, names_all, moves)
    for session in sessions.every():
        session.reader.note(evaluation)
        session.evaluation = evaluation
    return evaluation


def clear() -> None:
    """Cancel the running trace, and drop all sessions."""
    worker.shut_down()
    sessions.clear()
    revisions.mark_changed()


def cancel(resume: bool = False) -> None:
    """Cancel all running traces and computations, as `give_up`. Scenes whose frames are traced
    again have no result until then, the others none any more. Thread-safe."""
    give_up(resume)
    for session in sessions.every():
        session.postponed = None
        if session.is_interrupted or not resume:
            session.begun = session.result = session.shown = session.last = None


def give_up(resume: bool = False) -> None:
    """Cancel all running traces and computations; the shown results remain, and the next edit or
    frame is traced as usual. Thread-safe.

    resume: trace the same frame again as soon as nothing renders, or its result is asked for.
    """
    worker.cancel()
    for session in sessions.every():
        session.is_interrupted &= resume
        if session.begun is not None and not _ended_well(session.begun):
            _interrupted(session, resume)


def _interrupted(session: Session, resume: bool) -> None:
    """Replace the tracer of a frame that was cancelled, whose state may be inconsistent; resume:
    trace the frame again later."""
    tracer = session.tracer
    session.tracer = Tracer()
    session.tracer.collisions.take_over(tracer.collisions)
    session.history = History()
    session.begun = session.result = session.last = None
    session.is_interrupted = resume
    if resume:
        worker.call_after_render(_resume_all)


def _ended_well(begun: Future[Traced]) -> bool:
    """Whether the trace of a frame has ended by itself, with a result or an error."""
    return (
        begun.done()
        and not begun.cancelled()
        and not isinstance(begun.exception(), worker.Cancelled)
    )


def _resume_all() -> None:
    """Trace the frames again whose traces were cancelled with ``resume``."""
    for session in sessions.every():
        _resume(session)


def _resume(session: Session) -> None:
    if session.is_interrupted and session.request is not None:
        frame = replace(session.request.frame, continuous=False)
        _submit(session, replace(session.request, frame=frame))
    session.is_interrupted = False


def _submit(session: Session, request: TraceRequest, released: FrameResult | None = None) -> None:
    """Queue the trace of a frame and of its derived values on the worker, which also frees the
    result ``released``."""
    session.request = request
    session.begun = worker.submit(_step, session, request, released)
    if session.derived:
        worker.submit(_follow, session)


def make_way(seconds: float) -> None:
    """End the worker's jobs before a script goes on, if `THREADS_ENDANGER_SCRIPTS`. In an
    interactive session, those that take longer than ``seconds`` are cancelled and resumed after the
    script, or when their result is asked for."""
    if THREADS_ENDANGER_SCRIPTS and not worker.end_within(
        seconds if worker.is_interactive() else None
    ):
        give_up(resume=True)


def is_busy(scene: Scene, seconds: float) -> bool:
    """Whether, in an interactive session, the running trace takes longer than another
    ``seconds``."""
    session = known(scene)
    return (
        worker.is_interactive()
        and session is not None
        and session.begun is not None
        and not worker.done_within(session.begun, seconds)
    )


def follow_edit(scene: Scene, depsgraph: Depsgraph) -> bool:
    """Trace a scene again after an edit, see `begin`. Waits only briefly; an obsolete trace is
    cancelled.

    Returns whether it is traced now; else the viewports are redrawn when it is.
    """
    if is_busy(scene, worker.MOMENT):
        give_up()
    begin(scene, depsgraph, live=True)
    return not is_busy(scene, worker.MOMENT)


def trace(scene: Scene, depsgraph: Depsgraph, live: bool = False) -> FrameResult | None:
    """Trace the current state of the scene. See `begin`."""
    begin(scene, depsgraph, live)
    return result_of(scene)


def begin(
    scene: Scene,
    depsgraph: Depsgraph,
    live: bool = False,
    plays: bool = False,
    baked_impacts: str = "",
    evaluation: Evaluation | None = None,
    moment: Moment | None = None,
) -> None:
    """Wait for the trace of the last frame, read the current state of the scene, and begin to trace
    it on the worker. The result is None without tagged objects, or if a problem prevents it.

    While the timeline is paused, a frame keeps the impacts that it had when it was stepped or
    played to: modes, gains, materials and strategies are compared on the same impact, also after
    jumps. Impacts are dropped when their causes change: objects added, removed, moved, scaled,
    deformed or animated differently, masses and physics, and the rules of contacts and impacts
    (`CollisionDetector`, `motion_of`). Bakes and exports start without them.

    Args:
        scene: to trace.
        depsgraph: its evaluation.
        live: the result is only displayed: contacts that no signal reaches are skipped, and samples
            of consecutive frames are rendered only if something shows or asks for them.
        plays: a device plays the samples.
        baked_impacts: the impacts of the frame in a bake, as a text of `text_of_impacts`.
        evaluation: as of `SceneReader.read`.
        moment: of the frame; None for the scene's current one.
    """
    session = of(scene)
    moment = moment or Moment.of(scene)
    if session.postponed is not None:
        session.postponed = None
        session.reader.recheck_geometry()
    session.is_interrupted = False
    _finish(session)
    # A result holds much memory, which is freed on the worker, as that takes long.
    released, session.previous = session.previous, session.result
    if session.version != revisions.authored():
        session.reader.reread(revisions.changed_since(session.version))
        session.version = revisions.authored()
        if not session.tracer.collisions.stored or session.motion != motion_of(scene):
            session.tracer.collisions.forget_events()
            session.motion = None
    # From an exact frame on, tracing gives the same bits as from any earlier one.
    exact = moment.frame % EXACT_FRAMES == 0 or (is_stepped(scene) and session.last is None)
    started = time.perf_counter()
    reading = (
        None
        if session.reader.is_empty
        else session.reader.read(scene, depsgraph, exact, evaluation, moment.frame)
    )
    if reading is None or session.reader.is_empty:
        session.request = session.result = session.last = session.shown = None
        if reading is not None:
            session.failure = reading.problems
        return
    session.tracer.collisions.lazy = live
    session.tracer.collisions.settings = reading.contact_settings
    duration = frame_seconds(scene)
    continuous = moment.is_whole and _follows(scene, moment.frame, session.last)
    if continuous and session.motion is None:
        session.motion = motion_of(scene)
    _restore_impacts(scene, moment.frame, session, reading, baked_impacts)
    is_paused = not is_stepped(scene) and not is_playing()
    restore = moment.is_whole and is_paused
    anew, motion = frozenset[str](), None
    if continuous and session.request is not None:
        before = session.request.frame
        interval = scene, before.number, moment.frame, session.request.reading, reading
        anew = set_elsewhere(*interval)
        motion = known_motion(*interval, before.motion)
    session.last = (moment.frame, duration) if moment.is_whole else None
    heard = not (live and continuous) or plays or session.is_asked or shows_samples(session)
    session.is_asked = not continuous
    request = TraceRequest(
        frame_of(scene, reading, continuous, restore, exact, heard, anew, motion, moment.frame),
        reading,
        1000 * (time.perf_counter() - started),
        {
            "blender_milliseconds": 1000 * sessions.evaluation_seconds(),
            "waited_milliseconds": session.waited_milliseconds,
        },
        time.monotonic(),
    )
    _submit(session, request, released)


def _compare_modes(scene: Scene) -> None:
    """Trace the frame that is shown again, in another mode."""
    if sessions.shown(scene) is not None and not is_stepped(scene):
        begin(scene, traced_layer(scene).depsgraph)


def begin_stepped(scene: Scene) -> None:
    """Read a frame that was set and begin to trace it, whatever the settings of the preview: after
    the handlers of all add-ons have changed it, and Blender has evaluated that."""
    session = of(scene)
    if are_frames_shared():
        session.reader.recheck_geometry()
    begin(scene, traced_layer(scene).depsgraph, evaluation=session.evaluation)


def _follows(scene: Scene, frame: int, last: tuple[int, float] | None) -> bool:
    """Whether a frame follows the ``last`` one, see `Session.last`: it is the next one,
    or soon after it while the timeline plays, because Blender drops frames to keep up."""
    duration = frame_seconds(scene)
    if last is None or last[1] != duration:
        return False
    step = frame - last[0]
    return step == 1 or (1 < step <= _LONGEST_STEP / duration and is_playing())


def keep_impacts(scene: Scene) -> None:
    """Store the impacts of the shown frame in the scene before it is saved. A scene that was never
    traced, or whose trace takes long, is unchanged."""
    session = known(scene)
    if session is None or is_busy(scene, worker.MOMENT):
        return
    _finish(session)
    impacts_of = session.tracer.collisions.stored.of
    kept = None if session.request is None else impacts_of(scene.frame_current)
    text = "" if kept is None else text_of_impacts(scene.frame_current, kept, motion_of(scene))
    if scene.haptics.kept_impacts != text:
        scene.haptics.kept_impacts = text


def _restore_impacts(
    scene: Scene, frame: int, session: Session, reading: Reading, baked: str
) -> None:
    """Restore the impacts of a frame that were ``baked``, or, at the first trace of a scene, those
    that were stored when it was saved."""
    text = baked or (scene.haptics.kept_impacts if session.request is None else "")
    if not text or session.tracer.collisions.stored.of(frame) is not None:
        return
    motion = session.motion or motion_of(scene)
    kept = impacts_from_text(text, frame, [body.name for body in reading.bodies], motion)
    if kept is not None:
        session.tracer.collisions.restore_events(frame, reading.bodies, kept)
        session.motion = motion


def _step(session: Session, request: TraceRequest, released: FrameResult | None) -> Traced:
    """Trace a frame; called on the worker, which then frees ``released``. Raises ValueError,
    which names the object, if a designer's expression gives no valid gain."""
    try:
        result = session.tracer.step(request.frame)
        samples = np.zeros((len(result.listeners), 0))
        if request.frame.heard:
            session.history.feed(result)
            samples = session.history.all()
        result = replace(
            result,
            milliseconds={"read": request.read_milliseconds, **result.milliseconds},
            statistics={**result.statistics, **request.statistics},
        )
        traced = Traced(result, request.frame.settings, samples, request.reading)
    except Exception as error:
        if isinstance(error, ValueError):
            session.tracer.reset()
            session.failure = (Problem("", str(error)), *request.reading.problems)
        session.shown = None
        raise
    session.shown = traced
    return traced


def _follow(session: Session) -> None:
    """Compute the derived values of every frame; called on the worker."""
    for derived in tuple(session.derived):
        derived.follow(session)


def _finish(session: Session) -> None:
    """Wait for the running trace, and store its result."""
    _resume(session)
    begun, session.begun = session.begun, None
    if begun is None:
        return
    session.result = None
    started = time.perf_counter()
    try:
        session.result = worker.result_of(begun).result
    except ValueError:
        return  # see `Session.failure`
    except (worker.Cancelled, CancelledError):  # by a render, on its own thread
        _interrupted(session, resume=True)
        return
    session.waited_milliseconds = 1000 * (time.perf_counter() - started)


def frame_of(
    scene: Scene,
    reading: Reading,
    continuous: bool,
    restore: bool = False,
    exact: bool = False,
    heard: bool = True,
    anew: frozenset[str] = frozenset(),
    motion: KnownMotion | None = None,
    number: int | None = None,
) -> Frame:
    """The tracer's input for a reading.

    Args:
        scene: that was read.
        reading: of a frame.
        continuous: it follows the frame traced last.
        restore: if it does not follow, it has the impacts stored when it was last traced as one
            that does.
        exact: motions below the tolerance of rest count.
        heard: its samples are rendered.
        anew, motion: as of `Frame`.
        number: of the frame; None for the scene's current one.
    """
    number = scene.frame_current if number is None else number
    return Frame(
        number=number,
        time=seconds_of(scene, number),
        objects=reading.objects,
        sources=reading.sources,
        listeners=reading.listeners,
        settings=reading.settings,
        bodies=reading.bodies,
        transforms=reading.transforms,
        continuous=continuous,
        restore=restore,
        exact=exact,
        duration=frame_seconds(scene),
        heard=heard,
        anew=anew,
        motion=motion,
    )


file_changed.subscribe(clear)
mode_changed.subscribe(_compare_modes)
