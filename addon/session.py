"""The live tracing of each scene: its reader, its tracer and its last result. Plain Python, keyed by session id; nothing of it is saved."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

from bpy.types import Depsgraph, Scene

from ..core.tracer import Frame, FrameResult, Tracer
from .scene_reader import Problem, SceneReader, seconds_of


@dataclass(slots=True)
class Session:
    """One scene being traced."""

    reader: SceneReader = field(default_factory=SceneReader)
    tracer: Tracer = field(default_factory=Tracer)
    result: FrameResult | None = None
    problems: tuple[Problem, ...] = ()
    frame: int | None = None
    version: int = -1
    frame_entered: float = 0.0
    blender_milliseconds: float = 0.0  # of the last frame change, without tracing


_sessions: dict[int, Session] = {}
_version = 0


def mark_changed() -> None:
    """Something an author can change has changed, in some scene."""
    global _version
    _version += 1


def of(scene: Scene) -> Session:
    """The session of a scene, made at first use."""
    return _sessions.setdefault(scene.session_uid, Session())


def result_of(scene: Scene) -> FrameResult | None:
    """The last traced frame of a scene."""
    session = _sessions.get(scene.session_uid)
    return session.result if session is not None else None


def problems_of(scene: Scene) -> tuple[Problem, ...]:
    """What a designer should mend."""
    session = _sessions.get(scene.session_uid)
    return session.problems if session is not None else ()


def clear() -> None:
    """Forget every scene: on load, undo of everything, disable."""
    _sessions.clear()
    mark_changed()


def trace(scene: Scene, depsgraph: Depsgraph, *, geometry_changed: bool = False) -> FrameResult | None:
    """Trace the scene as it stands now and keep the result. None where nothing is tagged."""
    session = of(scene)
    if session.version != _version:
        session.reader.forget()
        session.version = _version
    if geometry_changed:
        session.reader.forget_shapes()
    if session.reader.is_empty:
        session.result = None
        session.problems = ()
        return None
    started = time.perf_counter()
    reading = session.reader.read(scene, depsgraph)
    number = scene.frame_current
    frame = Frame(
        number=number,
        time=seconds_of(scene, number),
        end=seconds_of(scene, number + 1),
        continuous=session.frame is not None and number == session.frame + 1,
        transforms=reading.transforms,
        objects=reading.objects,
        sources=reading.sources,
        listeners=reading.listeners,
        read_milliseconds=1000 * (time.perf_counter() - started),
    )
    session.tracer.configure(reading.settings, reading.contact_settings, reading.impact_settings, reading.bodies)
    session.frame = number
    session.result = session.tracer.step(frame)
    session.problems = reading.problems + tuple(Problem("", warning) for warning in session.result.warnings)
    return session.result
