"""The result as a table: every source at every listener that it reaches, and silent listeners."""

from __future__ import annotations

import math
from typing import NamedTuple

from bpy.types import Scene

from ..session import sessions
from . import levels, watched


class TableRow(NamedTuple):
    """A source at a listener: its gain [dB], and the listener's level and margin [dB]."""

    listener: str
    source: str
    gain: float
    level: float
    margin: float


def rows(scene: Scene) -> list[TableRow]:
    """The rows of the frame shown, names in their order and numbers from the highest on, by the
    column that the scene sorts by."""
    traced = sessions.shown(scene)
    if traced is None:
        return []
    result = traced.result
    shown = {level.listener: level for level in watched.levels_of(scene)}
    found = []
    for column, listener in enumerate(result.listeners):
        level = shown.get(listener.name)
        ends = (-math.inf, -math.inf) if level is None else (level.rms, level.margin)
        reaching = [
            TableRow(listener.name, source.name, 20 * math.log10(gain), *ends)
            for source, gain, amplitude in zip(
                result.sources,
                result.gains[:, column].tolist(),
                result.amplitudes[:, column].tolist(),
                strict=True,
            )
            if gain > 0 and amplitude > 0
        ]
        found += reaching or [TableRow(listener.name, "", -math.inf, *ends)]
    name = scene.haptics.meters.sort_table
    found.sort(key=lambda row: (row.listener, row.source))
    if name in ("gain", "level", "margin"):
        found.sort(key=lambda row: -getattr(row, name))
    elif name == "source":
        found.sort(key=lambda row: row.source)
    return found


def cells(row: TableRow) -> tuple[str, ...]:
    """A row as texts, empty where there is no number."""
    numbers = (levels.change_words(value) if math.isfinite(value) else "" for value in row[2:])
    return row.listener, row.source, *numbers
