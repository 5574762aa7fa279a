"""The summary at the top of the sidebar: what the chosen listener feels, from which source, or why
it feels nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Context, UILayout

from ...core.message import Chain, written
from ..bake import playback, storage
from ..blender.time import is_playing
from ..session import sessions
from ..translations.sentences import sentence
from ..view import explanation, levels, paths, watched
from .cures import draw_cure
from .drawing import draw_level, select_button
from .texts import draw_sentence, source_title

if TYPE_CHECKING:
    from ...core.diagnosis.waterfall import Waterfall


def draw_progress(layout: UILayout, context: Context) -> None:
    """Draw for how long a newer frame has been traced, with a button that cancels it."""
    seconds = sessions.seconds_behind(context.scene)
    if seconds > 0 and not is_playing():
        row = layout.row(align=True)
        row.label(
            text=iface_("Tracing for {:.0f} s...").format(seconds)
            if seconds >= 1
            else "Tracing...",
            icon="SORTTIME",
        )
        row.operator("haptic.cancel_tracing", text="", icon="X")


def draw_answer(layout: UILayout, context: Context) -> bool:
    """Draw the result of the watched listener. Returns False if there is no listener."""
    scene = context.scene
    if sessions.shown(scene) is None:
        return False
    name = watched.watched(scene)
    level = next((level for level in watched.levels_of(scene) if level.listener == name), None)
    if level is None:
        return False
    box = layout.box()
    if storage.played_track(scene) is not None and playback.known_stale_reasons(scene):
        row = box.split(factor=0.6)
        row.label(text="Baked, out of date", icon="ERROR")
        row.operator("haptic.bake", text="Bake Again", icon="REC")
    _draw_level(box, level)
    path = paths.path_of(scene)
    if path is not None and path.value is not None and path.value.fall.listener == name:
        _draw_origin(box, path.value.fall)
    if not level.is_felt:
        _draw_reasons(box, context, name)
    return True


def _draw_level(layout: UILayout, level: levels.Level) -> None:
    text = levels.decibels(level.rms)
    draw_level(layout, level, 0.5, text if level.is_silent else iface_("Level {}").format(text))
    if level.is_felt:
        layout.label(
            text=iface_("Felt: margin {}").format(level.margin_text()),
            icon="CHECKMARK",
            translate=False,
        )
    elif level.is_silent:
        layout.label(text="Feels nothing", icon="ERROR")
    else:
        layout.label(
            text=iface_("Too weak to be felt: margin {}").format(level.margin_text()),
            icon="ERROR",
            translate=False,
        )
        layout.operator("haptic.make_felt", icon="SORT_DESC").listener = level.listener


def _draw_origin(layout: UILayout, path: Waterfall) -> None:
    """Draw the strongest source, the gain from it, and the objects on its path."""
    split = layout.split(factor=0.6)
    name = path.source.name if path.source.second_object is None else path.source.object
    select_button(
        split, name, source_title(path.source, 0.6), icon="OUTLINER_OB_FORCE_FIELD", emboss=False
    )
    split.label(text=iface_("Gain {}").format(levels.decibels(path.gain)), translate=False)
    if path.hops:
        draw_sentence(
            layout, iface_("through {}").format(written(Chain(hop.object for hop in path.hops)))
        )


def _draw_reasons(layout: UILayout, context: Context, name: str) -> None:
    """Draw the first reason for silence, and its remedy."""
    why = explanation.why_silent(context.scene, name)
    if why.notice:
        draw_sentence(layout, why.notice, "INFO")
    if not why.is_current:
        layout.label(text="Looking for reasons...", icon="SORTTIME")
    for reason in why.reasons[:1] if why.is_current else ():
        draw_sentence(layout, sentence(reason), "INFO")
        draw_cure(layout, context, reason)
