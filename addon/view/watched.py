"""The watched listener, whose level, scope and path are shown, the sources that it feels, and the
levels of all listeners."""

from __future__ import annotations

import bpy
from bpy.types import Scene

from ...core.render.masking import FeltSources, felt_sources, shown_sounding
from ..blender.time import is_playing
from ..session import sessions
from ..session.derived import Derived, Latest
from ..session.sessions import Traced
from .levels import LEVELS, Level


def levels_of(scene: Scene) -> tuple[Level, ...]:
    """The levels of the last complete frame; () if there are none yet."""
    latest = LEVELS.latest(scene, is_playing())
    return () if latest is None else latest.value


def watched(scene: Scene) -> str:
    """The watched listener: the active object, else the last active listener, else the one that had
    the highest level when something was felt last; "" for none."""
    traced = sessions.shown(scene)
    own = sessions.known(scene)
    if traced is None or own is None:
        return ""
    names = [listener.name for listener in traced.result.listeners]
    active = active_name()
    if active in names:
        own.watched.active = active
    if own.watched.active in names:
        return own.watched.active
    levels = [level for level in levels_of(scene) if level.listener in names]
    if any(not level.is_silent for level in levels):
        own.watched.strongest = max(levels, key=lambda level: level.rms).listener
    return own.watched.strongest if own.watched.strongest in names else next(iter(names), "")


def active_name() -> str:
    """The full name of the active object, "" for none."""
    active = bpy.context.view_layer.objects.active
    return "" if active is None else active.name_full


def _felt(traced: Traced, listener: str, before: FeltSources | None = None) -> FeltSources | None:
    """Computed on the worker; None if the frame does not have that listener."""
    result = traced.result
    names = [item.name for item in result.listeners]
    return (
        felt_sources(shown_sounding(result), names.index(listener), result.sample_rate)
        if listener in names
        else None
    )


_FELT: Derived[str, FeltSources | None] = Derived(_felt)


def felt_at_watched(scene: Scene) -> Latest[FeltSources | None] | None:
    """The last result for the watched listener, without waiting."""
    listener = watched(scene)
    return _FELT.latest(scene, listener) if listener else None
