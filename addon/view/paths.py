"""The way from a source to a listener, object by object, and the rows that show it."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Scene

from ...core.diagnosis.waterfall import Waterfall, waterfall
from ...core.message import Metres, written
from ..blender.time import is_playing
from ..blender.words import ui_text
from ..session.derived import Derived, Latest
from ..session.sessions import Traced
from .levels import LEVEL_SECONDS, felt_samples, level_and_margin
from .watched import active_name, watched


class ListenerPath(NamedTuple):
    """The way to a listener from one of its sources, and the listener's margin [dB]."""

    fall: Waterfall
    margin: float


class PathRow(NamedTuple):
    """A row of the table: a name, which is an object's if ``is_object``, the distance as text, and
    the decibels of a sum (``is_sum``), else those that are added to the rows above."""

    name: str
    decibels: float
    distance: str = ""
    is_object: bool = False
    is_sum: bool = False


def listener_path(
    traced: Traced, choice: tuple[str, str, bool], before: ListenerPath | None = None
) -> ListenerPath | None:
    """Computed on the worker: the way to a listener from a source, or from the strongest one if
    that does not reach it; None if none does. ``choice``: the names of listener and source, and
    whether the timeline plays."""
    listener, chosen, plays = choice
    result = traced.result
    names = [item.name for item in result.listeners]
    if listener not in names:
        return None  # it was one in the frame before
    column = names.index(listener)
    reaching = [row for row in range(len(result.sources)) if result.amplitudes[row, column] > 0]
    if not reaching:
        return None
    named = [row for row in reaching if result.sources[row].name == chosen]
    row = (
        named[0] if named else max(reaching, key=lambda row: float(result.amplitudes[row, column]))
    )
    (level,), (margin,) = level_and_margin(
        felt_samples(traced, plays)[[column]], result.sample_rate, [result.listeners[column]]
    )
    return ListenerPath(
        waterfall(result, traced.settings.mode, row, column, float(level), LEVEL_SECONDS),
        float(margin),
    )


_PATH: Derived[tuple[str, str, bool], ListenerPath | None] = Derived(
    listener_path, every_frame=True, hears=True
)


def path_of(scene: Scene) -> Latest[ListenerPath | None] | None:
    """The way to the watched listener, from the active object if that is a source; without
    waiting."""
    listener = watched(scene)
    return _PATH.latest(scene, (listener, active_name(), is_playing())) if listener else None


def rows(path: ListenerPath, by_loss: bool = False) -> list[PathRow]:
    """The table of a path: decibels that add up from the source's amplitude to the level and the
    margin, in tenths that add up exactly. Rows of 0 dB after the objects are left out. ``by_loss``:
    objects are sorted by their losses, the largest first."""
    fall = path.fall
    hops = sorted(fall.hops, key=lambda hop: -hop.loss) if by_loss else fall.hops
    way = [
        PathRow(hop.object, -hop.loss, written(Metres(hop.distance)), is_object=True)
        for hop in hops
    ]
    always = [
        PathRow(ui_text("Source amplitude"), fall.amplitude),
        *(way or [PathRow(ui_text("Gain"), fall.gain)]),
    ]
    steps = [
        *always,
        PathRow(ui_text("Other paths"), fall.others if way else 0.0),
        PathRow(ui_text("Listener gain"), fall.listener_gain),
        PathRow(ui_text("RMS of the signal"), fall.signal),
        PathRow(ui_text("Other sources, limiter"), fall.mix),
    ]
    sums = [0.0]
    for step in steps:
        sums.append(sums[-1] + step.decibels)
    tenths = [round(value, 1) if math.isfinite(value) else value for value in sums]
    added = [
        step._replace(decibels=_difference(now, then))
        for step, (then, now) in zip(steps, pairwise(tenths), strict=True)
    ]
    shown = added[: len(always)] + [
        row for row in added[len(always) :] if abs(row.decibels) >= 0.05
    ]
    # Of other sources if this one is silent.
    level = tenths[-1] if math.isfinite(tenths[-1]) else round(fall.level, 1)
    shown.append(PathRow(iface_("Level", "Haptics"), level, is_sum=True))
    if math.isfinite(path.margin):
        margin = round(path.margin, 1)
        shown += [
            PathRow(ui_text("Threshold of feeling"), level - margin),
            PathRow(iface_("Margin", "Haptics"), margin, is_sum=True),
        ]
    return shown


def _difference(now: float, then: float) -> float:
    """The difference of two sums; minus infinity where the second one falls silent, 0 after
    that."""
    return now - then if math.isfinite(now) else -math.inf if math.isfinite(then) else 0.0
