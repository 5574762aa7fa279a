"""The summary at the top of the sidebar, always of the same height: whether the watched listener
feels something, and the cause; and the way to it, row by row."""

from __future__ import annotations

from bpy.types import Context, Scene, UILayout

from ...core.message import Cause, Chain, written
from ..bake import playback, storage
from ..blender.time import is_playing
from ..blender.words import show, show_pair, ui_text
from ..live_output import handlers, unfelt
from ..session import sessions
from ..translations.sentences import sentence
from ..view import doubtful_scale, explanation, levels, paths, watched
from .cures import draw_cure, draw_remedy
from .drawing import draw_problems, select_button
from .hints import Hint, button, next_step, of_units, striking_nothing
from .quick_start import HAPTIC_PT_quick_start
from .texts import draw_lines, draw_sentence, fitted, source_title

_CAUSE_LINES = 2
_WHY_LINES = 14
_OBJECTS, _NAMES = 0.48, 0.54  # of the width
_MUCH = 5.0  # milliseconds a frame of reading instances that are worth a notice


def draw_answer(layout: UILayout, context: Context) -> None:
    """Draw verdict and cause, or the next step unless the quick start shows it."""
    level = _watched_level(context.scene)
    cause = _cause(context, level)
    if level is None and not cause.words:
        return
    column = layout.box().column(align=True)
    if level is not None:
        _draw_verdict(column, level)
    most = _CAUSE_LINES + (level is None)
    _pad(column, most - draw_lines(column, cause.words, cause.icon, most))


def draw_remedy_of_cause(layout: UILayout, context: Context) -> None:
    """Draw the button that removes the cause, or takes the next step, if there is one."""
    cause = _cause(context, _watched_level(context.scene))
    if cause.draw is not None:
        cause.draw(layout)


def _cause(context: Context, level: levels.Level | None) -> Hint:
    """Why a listener feels what it feels, or the next step: what the user should know first."""
    scene = context.scene
    problems = sessions.shown_problems(scene)
    if problems:
        words = problems[0].message
        return Hint(words, "ERROR", lambda row: draw_remedy(row, context, problems[0]))
    hint = _urgent(scene, level is not None)
    if hint is None and level is None:
        hint = next_step(scene)
        if hint is not None and hint.is_in_quick_start and HAPTIC_PT_quick_start.poll(context):
            hint = None
    hint = hint or _notice(scene)
    if hint is not None or level is None:
        return hint or Hint()
    if level.is_silent:
        return _silence(context, level.listener)
    remedy = button("haptic.make_felt", "SORT_DESC", listener=level.listener)
    return Hint(_origin(scene, level), "BLANK1", None if level.is_felt else remedy)


def _pad(layout: UILayout, count: int) -> None:
    """Draw empty lines, such that what is below keeps its place."""
    for _ in range(count):
        layout.label(text="")


def _watched_level(scene: Scene) -> levels.Level | None:
    name = watched.watched(scene)
    return next((level for level in watched.levels_of(scene) if level.listener == name), None)


def _silence(context: Context, listener: str) -> Hint:
    """The first reason for silence."""
    why = explanation.why_silent(context.scene, listener)
    if not why.is_current:
        return Hint(ui_text("Looking for reasons..."))
    if not why.reasons:
        return Hint(why.notice)
    reason = why.reasons[0]
    lacks_source = any(reason.cause is Cause.NO_SOURCE for reason in why.reasons)
    walker = striking_nothing(context.scene) if lacks_source else None
    if walker is None:
        return Hint(sentence(reason), draw=lambda row: draw_cure(row, context, reason))
    armature, words = walker
    footsteps = button("haptic.add_footsteps", "MOD_DYNAMICPAINT", armature=armature)
    return Hint(words, draw=footsteps)


def _draw_verdict(layout: UILayout, level: levels.Level) -> None:
    """Draw a listener's name, which selects it, and whether it feels something, by how much."""
    split = layout.split(factor=_NAMES)
    row = split.row()
    row.alignment = "LEFT"
    name = fitted(level.title, _NAMES, icon=True, button=True)
    icon = "CHECKMARK" if level.is_felt else "ERROR"
    select_button(row, level.listener, name, icon=icon, emboss=False)
    show(split, level.verdict())


def _origin(scene: Scene, level: levels.Level) -> str:
    """The strongest source and, in a line of their own, the objects on its path; "" while they are
    not known."""
    path = paths.path_of(scene)
    if path is None or path.value is None or path.value.fall.listener != level.listener:
        return ""
    fall = path.value.fall
    name = source_title(fall.source, 0.7)
    if _is_estimated(scene, fall.source.name):
        name = ui_text("{} (estimated)", name)
    origin = ui_text("From {}", name)
    hops = [hop.object for hop in fall.hops if hop.object != fall.source.name]
    return "\n".join((origin, ui_text("through {}", written(Chain(hops))))) if hops else origin


def _is_estimated(scene: Scene, source: str) -> bool:
    """Whether a source of the shown frame is a blow that other poses between frames would
    change."""
    own, shown = sessions.known(scene), sessions.shown(scene)
    if own is None or shown is None:
        return False
    kept = own.tracer.collisions.stored.of(shown.result.number)
    return kept is not None and any(
        item.impact.estimated and item.source.name == source for item in kept.impacts
    )


def _urgent(scene: Scene, is_answered: bool) -> Hint | None:
    """Why the answer is not that of the scene, None if it is."""
    seconds = sessions.seconds_behind(scene)
    if is_answered and not scene.haptics.tracing:
        return next_step(scene)
    if seconds >= 1 and not is_playing():
        words = ui_text("Tracing for {:.0f} s...", seconds)
        return Hint(words, "SORTTIME", button("haptic.cancel_tracing"))
    if storage.played_track(scene) is not None and playback.known_stale_reasons(scene):
        return Hint(ui_text("Baked, out of date"), "ERROR", button("haptic.bake"))
    return None


def _notice(scene: Scene) -> Hint | None:
    """The first of what the user should know, None if there is nothing."""
    if handlers.is_new():
        return Hint(ui_text("Heard, too: see the speaker below"), "SPEAKER")
    if (moving := _moving_instances(scene)) is not None and moving[1] > _MUCH:
        words = ui_text("{:,} instances move: {:.0f} ms a frame", *moving)
        return Hint(words, draw=button("object.duplicates_make_real"))
    if (units := of_units(scene)) is not None:
        return units
    if (doubt := doubtful_scale.doubt(scene)) is not None:
        word, size = doubt
        words = ui_text("'{}' of {:.0f} m") if word else ui_text("{1:,} objects, no contact")
        unit_settings = scene.unit_settings
        return Hint(
            words.format(word, size),
            "QUESTION",
            lambda row: row.prop(unit_settings, "scale_length"),
        )
    return None


def _moving_instances(scene: Scene) -> tuple[int, float] | None:
    """How many instances were read in the shown frame, and the milliseconds that took."""
    traced = sessions.shown(scene)
    return None if traced is None or traced.reading is None else traced.reading.moving_instances


def draw_why(layout: UILayout, context: Context) -> None:
    """Draw the problems of the scene, and, in a fixed number of lines, the way to the watched
    listener or the reasons for which it feels nothing."""
    draw_problems(layout, context)
    scene = context.scene
    name = watched.watched(context.scene)
    column = layout.column(align=True)
    level = _watched_level(scene)
    path = paths.path_of(scene)
    if level is None:
        used = draw_lines(column, ui_text("No listener: add one to feel something"))
    elif path is None or path.value is None or level.is_silent:
        used = _draw_reasons(column, context, explanation.why_silent(scene, name))
    else:
        used = _draw_path(column, context, path.value)
    if getattr(context.region, "type", "UI") == "UI":  # nothing is below a popover
        _pad(column, _WHY_LINES - used)
    if level is not None and level.is_assumed:
        draw_sentence(layout, ui_text("Not calibrated: its margins are assumed"), "INFO")
    if name:
        draw_sentence(layout, unfelt.device_words(scene, name))


def _draw_reasons(layout: UILayout, context: Context, why: explanation.Explanation) -> int:
    """Draw reasons with their cures. Returns the number of lines."""
    used = draw_lines(layout, why.notice, "INFO", 3) if why.notice else 0
    if not why.is_current:
        layout.label(text="Looking for reasons...", icon="SORTTIME")
        return used + 1
    for reason in why.reasons:
        if used + 6 > _WHY_LINES:
            break
        used += draw_lines(layout, sentence(reason), "INFO", 5)
        used += draw_cure(layout.row(align=True), context, reason)
    return used


def _draw_path(layout: UILayout, context: Context, path: paths.ListenerPath) -> int:
    """Draw the table of a path: an object has a button that selects it, pressed for the active one,
    and its distance. Returns the number of lines."""
    meters = context.scene.haptics.meters
    row = layout.row(align=True)
    show(row, source_title(path.fall.source, 0.8))
    row.prop(meters, "sort_path", text="", icon="SORTSIZE")
    rows = paths.rows(path, meters.sort_path)
    surplus = len(rows) + 1 - _WHY_LINES
    last = sum(row.is_object for row in rows)
    if surplus > 0:
        cut = rows[last - surplus : last + 1]
        more = ui_text("and {} more", len(cut))
        rows[last - surplus : last + 1] = [paths.PathRow(more, sum(row.decibels for row in cut))]
    active = context.object.name_full if context.object is not None else ""
    for item in rows:
        words = levels.change_words(item.decibels)
        if item.is_object:
            split = layout.split(factor=_OBJECTS, align=True)
            title = fitted(item.name, _OBJECTS, button=True)
            select_button(split, item.name, title, depress=item.name == active)
            show_pair(split, item.distance, words, 0.45)
        else:
            show_pair(layout, f"= {item.name}" if item.is_sum else item.name, words, 0.76)
    return len(rows) + 1
