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
from .hints import Hint, next_step, of_units, striking_nothing
from .quick_start import HAPTIC_PT_quick_start
from .texts import draw_lines, draw_sentence, fitted, source_title

_CAUSE_LINES = 2
_WHY_LINES = 14
_OBJECTS, _NAMES, _NOTICE = 0.48, 0.5, 0.62  # of the width
_MUCH = 5.0  # milliseconds a frame of reading instances that are worth a notice


def draw_answer(layout: UILayout, context: Context) -> None:
    """Draw verdict and cause, or the next step unless the quick start shows it, and one row for a
    remedy or a notice."""
    scene = context.scene
    level = _watched_level(scene)
    problems = sessions.shown_problems(scene)
    hint = next_step(scene) if level is None else None
    if (
        hint is not None
        and hint.is_in_quick_start
        and not problems
        and HAPTIC_PT_quick_start.poll(context)
    ):
        _draw_notice(layout.row(align=True), scene)
        return
    column = layout.box().column(align=True)
    lines, reasons = _CAUSE_LINES, explanation.Explanation()
    if level is not None:
        _draw_verdict(column, level)
        if level.is_silent:
            reasons = explanation.why_silent(scene, level.listener)
    else:
        lines += 1
    words = "" if hint is None else hint.words
    if problems:
        words = problems[0].message
    elif level is not None:
        words = _first_words(scene, reasons) if level.is_silent else _origin(scene, level)
    is_fine = level is not None and level.is_felt and not problems
    icon = "ERROR" if problems else "BLANK1" if is_fine else "INFO"
    used = draw_lines(column, words, icon, lines) if words else 0
    _pad(column, lines - used)
    row = column.row(align=True)
    if not (
        (problems and draw_remedy(row, context, problems[0]))
        or _draw_urgent(row, scene, level is not None)
        or _draw_cure(row, context, level, hint, reasons)
        or _draw_notice(row, scene)
    ):
        _pad(row)


def _pad(layout: UILayout, count: int = 1) -> None:
    """Draw empty lines, such that what is below keeps its place."""
    for _ in range(count):
        layout.label(text="")


def _watched_level(scene: Scene) -> levels.Level | None:
    name = watched.watched(scene)
    return next((level for level in watched.levels_of(scene) if level.listener == name), None)


def _lacks_source(why: explanation.Explanation) -> bool:
    return why.is_current and any(reason.cause is Cause.NO_SOURCE for reason in why.reasons)


def _first_words(scene: Scene, why: explanation.Explanation) -> str:
    """The first reason for silence."""
    if not why.is_current:
        return ui_text("Looking for reasons...")
    if _lacks_source(why) and (walker := striking_nothing(scene)) is not None:
        return walker[1]
    return sentence(why.reasons[0]) if why.reasons else why.notice


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
    """The strongest source and the objects on its path, "" while they are not known."""
    path = paths.path_of(scene)
    if path is None or path.value is None or path.value.fall.listener != level.listener:
        return ""
    fall = path.value.fall
    if not fall.hops:
        return ui_text("From {}", fall.source.name)
    chain = written(Chain(hop.object for hop in fall.hops))
    return ui_text("From {} through {}", fall.source.name, chain)


def _draw_cure(
    row: UILayout,
    context: Context,
    level: levels.Level | None,
    hint: Hint | None,
    why: explanation.Explanation,
) -> bool:
    """Draw the button of the next step or of what makes the listener feel something. Returns False
    if there is none."""
    if hint is not None:
        for operator, icon in hint.operators:
            row.operator(operator, icon=icon)
        return bool(hint.operators)
    if level is not None and not level.is_silent and not level.is_felt:
        row.operator("haptic.make_felt", icon="SORT_DESC").listener = level.listener
        return True
    if _lacks_source(why) and (walker := striking_nothing(context.scene)) is not None:
        row.operator("haptic.add_footsteps", icon="MOD_DYNAMICPAINT").armature = walker[0]
        return True
    return bool(why.is_current and why.reasons) and draw_cure(row, context, why.reasons[0])


def _draw_urgent(row: UILayout, scene: Scene, is_answered: bool) -> bool:
    """Draw why the answer is not that of the scene, with its button. Returns False if it is."""
    seconds = sessions.seconds_behind(scene)
    if is_answered and not scene.haptics.tracing:
        row.label(text="Tracing is switched off", icon="ERROR")
        row.operator("haptic.toggle_tracing", text="", icon="HIDE_OFF")
    elif seconds >= 1 and not is_playing():
        show(row, ui_text("Tracing for {:.0f} s...", seconds), "SORTTIME")
        row.operator("haptic.cancel_tracing", text="", icon="X")
    elif storage.played_track(scene) is not None and playback.known_stale_reasons(scene):
        split = row.split(factor=_NOTICE, align=True)
        split.label(text="Baked, out of date", icon="ERROR")
        split.operator("haptic.bake", text="Bake Again")
    else:
        return False
    return True


def _draw_notice(row: UILayout, scene: Scene) -> bool:
    """Draw the first of what the user should know, with its button. Returns False if there is
    nothing."""
    if handlers.is_new():
        row.label(text="Heard, too: see the speaker below", icon="SPEAKER")
    elif (moving := _moving_instances(scene)) is not None and moving[1] > _MUCH:
        words = ui_text("{:,} instances move: {:.0f} ms a frame", *moving)
        show(row, words, "INFO")
        row.operator("haptic.realize_instances", text="", icon="OUTLINER_OB_GROUP_INSTANCE")
    elif (units := of_units(scene)) is not None:
        show(row, units.words, "INFO")
        for operator, icon in units.operators:
            row.operator(operator, text="", icon=icon)
    elif (doubt := doubtful_scale.doubt(scene)) is not None:
        word, size = doubt
        words = ui_text("'{}' of {:.0f} m") if word else ui_text("{1:,} objects, no contact")
        show(row, words.format(word, size), "QUESTION")
        row.prop(scene.unit_settings, "scale_length")
    else:
        return False
    return True


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
        if used + 4 > _WHY_LINES:
            break
        used += draw_lines(layout, sentence(reason), "INFO", 3)
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
