"""Labels and legend of the haptic graph over a viewport, independent of the GPU."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Literal

import numpy as np

from ...core.arrays import FloatArray
from ..blender.words import ui_text
from .colour_map import STEPS, AmplitudeScale, colour_table
from .cues import Cue
from .hud import FAINT_INK, INK, PLATE, SMALL_TEXT, TEXT_SIZE, Hud, HudBuilder, Rectangle, overlaps
from .label_placement import place_labels, project, squares_around
from .render_data import Lines, Place, RenderData, Size
from .symbols import Symbol

_PADDING = (6.0, 4.0)
_NAME_WIDTH = 150.0  # points
_GAP = 5.0  # points between a place's symbol and its label
_MARGIN = 12.0  # points between the legend and the edges
_LEGEND_WIDTH, _LEGEND_HEIGHT, _LEGEND_PADDING = 120.0, 58.0, 10.0  # points
_BAR_HEIGHT, _BAR_BOTTOM = 10.0, 24.0  # points
_MOST_STEPS, _MOST_LABELS = 150, 32  # all body parts, and some sources
LegendSide = Literal["LEFT", "RIGHT", "NONE"]


def placed_annotations(
    data: RenderData,
    perspective: FloatArray,
    size: Size,
    scale: float,
    free: Rectangle,
    occupied: Sequence[Rectangle] = (),
    legend: LegendSide = "RIGHT",
    frame: Rectangle | None = None,
    cues: Sequence[Cue] = (),
    felt: Sequence[tuple[str, str, str]] = (),
) -> Hud:
    """Labels, cues and legend for a viewport.

    Args:
        data: the drawn frame.
        perspective: from the world to clip space (4, 4).
        size: of the viewport [pixels].
        scale: pixels per point.
        free: the part of the viewport that the user interface does not cover.
        occupied: rectangles within it where something else is drawn.
        legend: the side of the legend, in the lower corner.
        frame: the camera's frame, which the legend does not cover.
        cues: words about objects out of sight.
        felt: names of listeners, their titles, and by how much they feel something.
    """
    builder = HudBuilder(scale)
    _add_cues(builder, cues, free, occupied)
    placed = builder.build()
    if legend != "NONE":
        taken = (*occupied, *placed.bounds, *(() if frame is None else (frame,)))
        placed = placed.joined(_placed_legend(data.scale, free, scale, taken, legend == "LEFT"))
    if not data.labels:
        return placed
    builder = HudBuilder(scale)
    _add_labels(
        builder,
        data,
        perspective,
        size,
        free,
        np.array([*placed.bounds, *occupied]).reshape(-1, 4),
        {name: words for name, *words in felt},
    )
    return placed.joined(builder.build())


def _add_cues(
    builder: HudBuilder, cues: Sequence[Cue], free: Rectangle, occupied: Sequence[Rectangle]
) -> None:
    """Plates with the words of cues within ``free``, each at its place or above what is there."""
    (x0, y0, x1, y1), *taken = (np.array([free, *occupied]) / builder.scale).tolist()
    height = TEXT_SIZE * 0.95 + 2 * _PADDING[1]
    for cue in cues:
        x, y = (place / builder.scale for place in cue.place)
        width = builder.width(cue.words) + 2 * _PADDING[0]
        left = min(max(x - width / 2, x0 + _MARGIN), x1 - _MARGIN - width)
        bottom = min(max(y - height / 2, y0 + _MARGIN), y1 - _MARGIN - height)
        is_low = 2 * bottom < y0 + y1
        for _ in range(len(cues) + len(occupied)):
            plate = left, bottom, left + width, bottom + height
            under = [other for other in taken if overlaps(other, plate)]
            if not under:
                break
            bottom = under[0][3] + 1 if is_low else under[0][1] - height - 1
        if plate[1] < y0 or plate[3] > y1:
            continue
        builder.panel(plate[:2], plate[2:], 4.0)
        taken.append(plate)
        builder.text(cue.words, _start(left, bottom), FAINT_INK)


def _start(left: float, bottom: float) -> Place:
    """Where the text on a plate begins."""
    return left + _PADDING[0], bottom + _PADDING[1] + 1.2


def _add_labels(
    builder: HudBuilder,
    data: RenderData,
    perspective: FloatArray,
    size: Size,
    free: Rectangle,
    occupied: FloatArray,
    felt: Mapping[str, Sequence[str]],
) -> None:
    """Labels on plates beside their places.

    Args:
        builder: Takes them.
        data: The drawn frame, with the labels and what they should not cover.
        perspective: From the world to clip space (4, 4).
        size: Of the viewport [pixels].
        free: The part of it that the user interface does not cover.
        occupied: Rectangles (m, 4) where something else is drawn.
        felt: Titles of listeners and what they feel, by their names.
    """
    scale = builder.scale
    anchor = project(np.array([label.position for label in data.labels]), perspective, size)
    priority = np.where(np.isnan(anchor[:, 0]), -np.inf, [label.priority for label in data.labels])
    shown = np.argsort(-priority, kind="stable")[: min(_MOST_LABELS, np.isfinite(priority).sum())]
    labels = [data.labels[k] for k in shown.tolist()]
    if not labels:
        return
    anchor = anchor[shown]
    space = builder.width(" ") * 1.6
    titles, values = zip(*(felt.get(label.name, (label.name, "")) for label in labels), strict=True)
    titles = tuple(builder.fitted(title, _NAME_WIDTH) for title in titles)
    names = np.array(list(map(builder.width, titles)))
    widths = names + np.array([space + builder.width(value) if value else 0.0 for value in values])
    heights = np.full(len(labels), TEXT_SIZE * 0.95)
    extent = np.column_stack([widths, heights]) + 2 * np.array(_PADDING)
    clearance = np.array([label.clearance for label in labels]) + _GAP
    symbols = data.points.shape != Symbol.CONTACT
    places = project(data.points.position[symbols, 0].astype(np.float64), perspective, size)
    occupied = np.concatenate(
        [occupied, squares_around(places, scale * data.points.width[symbols] / 2)]
    )
    paths = project(_along_paths(data.paths), perspective, size)
    shown_paths = paths[~np.isnan(paths[:, 0])]
    corner = place_labels(anchor, scale * extent, scale * clearance, free, occupied, shown_paths)
    lows = np.round(corner) / scale
    places = np.column_stack([anchor / scale, lows, lows + extent]).tolist()
    for k in np.flatnonzero(~np.isnan(corner[:, 0])).tolist():
        label, (x, y, left, bottom, right, top) = labels[k], places[k]
        nearest = min(max(x, left), right), min(max(y, bottom), top)
        if math.dist(nearest, (x, y)) > clearance[k] + _GAP:
            builder.line((x, y), nearest, (*FAINT_INK, 0.8), 1.0)
        builder.plate((left, bottom), (right, top), PLATE, 4.0)
        start, base = _start(left, bottom)
        builder.text(titles[k], (start, base), INK)
        if values[k]:
            builder.text(values[k], (start + float(names[k]) + space, base), label.colour)


def _along_paths(lines: Lines) -> FloatArray:
    """Places (k, 3) along the best paths, which labels should not cover."""
    ends = lines.position[-_MOST_STEPS:].astype(np.float64)
    part = np.linspace(0, 1, 12)[None, :, None]
    return (ends[:, :1] * (1 - part) + ends[:, 1:] * part).reshape(-1, 3)


def _placed_legend(
    amplitudes: AmplitudeScale,
    free: Rectangle,
    scale: float,
    occupied: Sequence[Rectangle],
    at_left: bool,
) -> Hud:
    """The legend in its corner; none if there is not enough room.

    Args:
        amplitudes: The scale of the colours, which it explains.
        free: The part of the viewport that the user interface does not cover.
        scale: Pixels per point.
        occupied: Rectangles above which it stands.
        at_left: In the lower left corner, else in the right one.
    """
    margin = _MARGIN * scale
    legend = _legend(amplitudes, ui_text("Amplitude"), scale)
    ((_, _, width, height),) = legend.bounds
    left = round(free[0] + margin if at_left else free[2] - margin - width)
    bottoms = [free[1], *(top for _, _, _, top in occupied)]
    for bottom in sorted(round(edge + margin) for edge in bottoms):
        place = left, bottom, left + width, bottom + height
        highest = min(free[3], (free[1] + free[3]) / 2 + height)
        inside = free[0] <= left and place[2] <= free[2] and place[3] <= highest
        if inside and not any(overlaps(place, other) for other in occupied):
            return legend.moved(left, bottom)
    return HudBuilder(scale).build()


@lru_cache(maxsize=16)
def _legend(amplitudes: AmplitudeScale, title: str, scale: float) -> Hud:
    """The legend with a ``title``, its lower left corner at the origin; ``scale``: pixels per
    point."""
    builder = HudBuilder(scale)
    builder.panel((0, 0), (_LEGEND_WIDTH, _LEGEND_HEIGHT), 6.0)
    _add_colours(builder, amplitudes, title, _LEGEND_WIDTH, amplitudes.ticks()[:1])
    return builder.build()


def _add_colours(
    builder: HudBuilder,
    amplitudes: AmplitudeScale,
    title: str,
    width: float,
    ticks: Sequence[int],
) -> None:
    """The colours from the floor of the scale to 0 dB.

    Args:
        builder: Takes them.
        amplitudes: The scale of the colours.
        title: Above them.
        width: Of the legend.
        ticks: Numbers below them [dB].
    """
    parts = 32
    left, bottom = _LEGEND_PADDING, _BAR_BOTTOM
    width -= 2 * left
    for part in range(parts):
        # Each part extends under the next one, so that no seam is visible.
        low = part / parts
        high = min((part + 2) / parts, 1.0)
        first, last = (colour_table()[round(place * (STEPS - 1))] for place in (low, high))
        builder.plate(
            (left + low * width, bottom),
            (left + high * width, bottom + _BAR_HEIGHT),
            (*first, 1),
            0.0,
            (*last, 1),
        )
    builder.text(title, (left, bottom + _BAR_HEIGHT + 6), FAINT_INK, SMALL_TEXT)
    for tick in dict.fromkeys((*ticks, 0)):
        x = left + (1 - tick / amplitudes.floor) * width
        builder.plate((x - 0.5, bottom - 4), (x + 0.5, bottom), (*FAINT_INK, 1), 0.0)
        words = f"\N{MINUS SIGN}{-tick}" if tick else "0 dB"
        text_width = builder.width(words, SMALL_TEXT)
        x = min(max(x - text_width / 2, left), left + width - text_width)
        builder.text(words, (x, bottom - 14), FAINT_INK, SMALL_TEXT)
