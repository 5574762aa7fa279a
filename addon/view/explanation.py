"""Why a listener of the scene feels nothing: the core's reasons, and those that only Blender knows. Looked for when asked, kept per
frame."""

from __future__ import annotations

import time
from typing import Any

import bpy
from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Scene

from ...core.diagnosis.gaps import Surroundings
from ...core.diagnosis.silence import reasons
from ...core.message import Message
from ...core.render.frame_result import FrameResult
from ..scene_reader.settings import read_settings
from ..session import session
from .levels import RMS_SECONDS

_PATIENCE = 0.004  # seconds that looking may take while the timeline plays

_known: dict[tuple[int, str], tuple[FrameResult, Any, tuple[Message, ...], float]] = {}


def why_silent(scene: Scene, listener: str) -> tuple[str, tuple[Message, ...]]:
    """Why a listener feels nothing: one sentence about the scene ("" where there is nothing to say), and the core's reasons; () and ""
    where it feels something."""
    haptics = scene.haptics
    result = session.result_of(scene)
    if not haptics.tracing and result is None:
        return iface_("Tracing is switched off: tick the box of the panel Haptic Tracing"), ()
    if result is None:
        problems = session.problems_of(scene)
        return (problems[0].message if problems else iface_("Nothing has been traced yet: play, or press Trace This Frame")), ()
    names = [item.name for item in result.listeners]
    if listener not in names:
        return iface_("It was no listener when this frame was traced"), ()
    stale = iface_("Tracing is switched off: this is how the scene was before.") if not haptics.tracing else ""
    return stale, _reasons(scene, result, names.index(listener))


def _reasons(scene: Scene, result: FrameResult, index: int) -> tuple[Message, ...]:
    name = result.listeners[index].name
    settings = read_settings(scene)
    key = (scene.session_uid, name)
    known = _known.get(key)
    if known is not None and ((known[0] is result and known[1] == settings) or (known[3] > _PATIENCE and _is_playing())):
        return known[2]
    started = time.perf_counter()
    reading = session.of(scene).reading
    around = None
    if reading is not None and {body.name for body in reading.bodies} <= set(result.objects):
        around = Surroundings(reading.bodies, reading.transforms, reading.contact_settings)
    recent = session.of(scene).history.samples(name, RMS_SECONDS)
    found = reasons(result, settings, index, around, _muted(result), recent if len(recent) else None)
    if len(_known) > 256:
        _known.clear()
    _known[key] = (result, settings, found, time.perf_counter() - started)
    return found


def _muted(result: FrameResult) -> set[str]:
    objects = ((source.name, bpy.data.objects.get(source.name)) for source in result.sources)
    return {name for name, obj in objects if obj is not None and obj.haptics.source.muted}


def _is_playing() -> bool:
    screen = bpy.context.screen
    return screen is not None and screen.is_animation_playing


def forget() -> None:
    """Another file is loaded, or the add-on ends."""
    _known.clear()
