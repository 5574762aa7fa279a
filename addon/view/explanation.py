"""Why a listener of the scene feels nothing: the core's reasons, and those specific to Blender."""

from __future__ import annotations

from collections.abc import Sequence

from bpy.types import Scene

from ...core.diagnosis.gaps import Surroundings
from ...core.diagnosis.silence import reasons
from ...core.frozen import frozen
from ...core.message import Message
from ...core.scene.values import Listener, Source
from ..blender.full_names import object_named
from ..blender.time import is_playing
from ..blender.words import ui_text
from ..scene_reader.roles import is_silenced, solo_roles
from ..session import sessions
from ..session.derived import Derived
from ..session.sessions import Traced
from .levels import felt_samples


@frozen
class Explanation:
    """``notice``: a sentence about the scene, "" for none. ``reasons``: the core's; () if the
    listener feels something. ``is_current``: False while the reasons for the shown frame are
    computed."""

    notice: str = ""
    reasons: tuple[Message, ...] = ()
    is_current: bool = True


def _reasons(
    traced: Traced, question: tuple[str, frozenset[str], bool], before: tuple[Message, ...] | None
) -> tuple[Message, ...]:
    """Computed on the worker: why a listener feels nothing. ``question``: the listener, the sources
    that are muted, and whether the timeline plays."""
    listener, muted, plays = question
    result, reading = traced.result, traced.reading
    index = [item.name for item in result.listeners].index(listener)
    waiting = (
        []
        if reading is None
        else [source.name for source in reading.sources if source.triggers is not None]
    )
    around = None
    if reading is not None and {body.name for body in reading.bodies} <= set(result.objects):
        around = Surroundings(reading.bodies, reading.transforms, reading.contact_settings)
    recent = felt_samples(traced, plays)[index]
    return reasons(
        result, traced.settings, index, around, muted, recent if len(recent) else None, waiting
    )


_REASONS: Derived[tuple[str, frozenset[str], bool], tuple[Message, ...]] = Derived(_reasons)


def why_silent(scene: Scene, listener: str) -> Explanation:
    """Why a listener feels nothing, as computed so far, without waiting."""
    traced = sessions.shown(scene)
    if not scene.haptics.tracing and traced is None:
        return Explanation(
            ui_text("Tracing is switched off: tick the box of the panel Haptic Tracing")
        )
    if traced is None:
        problems = sessions.shown_problems(scene)
        return Explanation(
            problems[0].message
            if problems
            else ui_text("Nothing has been traced yet: play, or press Trace This Frame")
        )
    if listener not in [item.name for item in traced.result.listeners]:
        return Explanation(ui_text("It was no listener when this frame was traced"))
    if listener in _silenced(traced.result.listeners, "listener"):
        return Explanation(
            ui_text("It is muted, or others are solo: see the buttons beside it in What Is Felt")
        )
    notice = (
        ""
        if scene.haptics.tracing
        else ui_text("Tracing is switched off: this is how the scene was before.")
    )
    latest = _REASONS.latest(
        scene, (listener, _silenced(traced.result.sources, "source"), is_playing())
    )
    return (
        Explanation(notice, (), False)
        if latest is None
        else Explanation(notice, latest.value, latest.is_current)
    )


def _silenced(items: Sequence[Source] | Sequence[Listener], role: str) -> frozenset[str]:
    """The names of the sources or listeners that are muted or not solo."""
    found = [obj for obj in (object_named(item.name) for item in items) if obj is not None]
    solo = solo_roles(found)
    return frozenset(obj.name_full for obj in found if is_silenced(obj, role, solo))
