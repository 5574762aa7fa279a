"""The live tracing of each scene: its reader, its tracer and its last result. Plain Python, keyed by session id; nothing of it is saved."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace

import numpy as np
from bpy.types import Depsgraph, Scene
from numpy.typing import NDArray

from ..core.frame_result import FrameResult
from ..core.tracer import Frame, Tracer
from .meters.history import History
from .modalities import feeling
from .scene_reader import Problem, Reading, SceneReader, seconds_of


@dataclass(slots=True)
class Session:
    """One scene being traced."""

    reader: SceneReader = field(default_factory=SceneReader)
    tracer: Tracer = field(default_factory=Tracer)
    reading: Reading | None = None
    result: FrameResult | None = None
    problems: tuple[Problem, ...] = ()
    frame: int | None = None
    frame_seconds: float = 0.0
    version: int = -1
    history: History = field(default_factory=History)


_sessions: dict[int, Session] = {}
_version = 0
_edits = 0
_begun = 0.0
_evaluating = 0.0


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
    """The last traced frame of a scene."""
    session = _sessions.get(scene.session_uid)
    return session.result if session is not None else None


def problems_of(scene: Scene) -> tuple[Problem, ...]:
    """What a designer should mend."""
    session = _sessions.get(scene.session_uid)
    return session.problems if session is not None else ()


def show(scene: Scene, result: FrameResult, samples: NDArray[np.float64]) -> None:
    """Keep a result that was read from a track instead of being traced, and the ``samples`` (l, n) that lead up to its end."""
    session = of(scene)
    session.result, session.frame = result, None
    session.history.take(result, samples)


def clear() -> None:
    """Forget every scene."""
    _sessions.clear()
    feeling.forget()
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
    """Trace the scene as it stands now and keep the result. None where nothing is tagged, or where a problem forbids it. ``live``: for the
    moment only, so that contacts that no signal gets to need not be looked for."""
    session = of(scene)
    if session.version != _version:
        session.reader.forget()
        session.version = _version
    started = time.perf_counter()
    reading = None if session.reader.is_empty else session.reader.read(scene, depsgraph)
    if reading is None or session.reader.is_empty:
        session.reading, session.result, session.problems, session.frame = None, None, (), None
        return None
    read_milliseconds = 1000 * (time.perf_counter() - started)
    session.reading = reading
    session.tracer.lazy = live and not feeling.wanted_in(scene)
    session.tracer.contact_settings = reading.contact_settings
    session.tracer.impact_sources = scene.haptics.impacts
    session.tracer.impact_materials = reading.impact_materials if scene.haptics.impact_signal == "MATERIALS" else {}
    step, whole = scene.render.fps_base / scene.render.fps, scene.frame_subframe == 0
    follows = session.frame is not None and scene.frame_current == session.frame + 1
    continuous = whole and follows and step == session.frame_seconds
    session.frame, session.frame_seconds = scene.frame_current if whole else None, step
    try:
        result = session.tracer.step(frame_of(scene, reading, continuous))
    except ValueError as error:
        session.tracer.reset()
        session.result = None
        session.problems = (*reading.problems, Problem("", str(error)))
        return None
    session.result = replace(
        result,
        milliseconds={"read": read_milliseconds, **result.milliseconds},
        statistics={**result.statistics, "blender_milliseconds": 1000 * _evaluating},
    )
    session.history.feed(result)
    session.problems = reading.problems + tuple(Problem("", warning) for warning in result.warnings) + feeling.trace(scene, result)
    return session.result


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
