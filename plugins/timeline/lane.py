"""The timeline of touch, a lane over Dope Sheet and Timeline: the strength of sources and listeners
in all frames that were baked or played, impacts, and one-shots that can be dragged."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import bpy
import gpu
import numpy as np
from bpy.types import Context
from gpu_extras.batch import batch_for_shader

from ...addon.blender.arrays import read_array
from ...addon.blender.compatibility import fcurves_of
from ...addon.blender.time import frame_seconds
from ...addon.changes.events import file_changed
from ...addon.scene_reader.triggers import PATH
from ...addon.session import sessions
from ...addon.session.derived import Derived
from ...addon.view.layout import pixels_per_point
from ...addon.view.levels import LEVEL_SECONDS
from ...addon.view.render_data import Place
from ...addon.view.screen import Recent, Uploaded, draw_flat, uploaded
from ...addon.view.watched import active_name, watched
from ...core.arrays import FloatArray
from ...core.frozen import frozen
from ...core.render.frame_result import FrameResult
from ...core.render.lane import bands, height_of, level_and_threshold
from ...core.scene.values import SourceKind
from .rows import (
    SMALL,
    Colours,
    LaneRow,
    Mark,
    grounds,
    names,
    rows_of,
    snapped,
    stems,
    strip,
)
from .waves import Waves, row_name, wave_band

_REACH = 7.0  # points around a one-shot, and around what it snaps to
_MOST_BYTES = 1 << 27
"""Largest size of the stored samples of played frames: 14 minutes of ten listeners."""
_OPACITY = {"felt": 0.35, "threshold": 0.5, "amplitude": 1.0, "level": 1.0, "wave": 0.9}


@frozen
class _Range:
    """The frame range of a scene and the settings of its trace, which together identify stored
    waves."""

    scene: int  # session id
    first: int
    last: int
    seconds: float  # of a frame
    mode: str
    strategy: str


class _View(NamedTuple):
    """All that the lane of a region depends on: it is drawn anew when one of these differs.

    Attributes:
        kept: number of the last frame whose samples are stored.
        waves: identities of the waves.
        size: of the region [pixels].
        scale: pixels per point.
        frames: at the left and right edge.
        first: names that always have a row.
        colours: of the theme.
        wave: whether waves are drawn in place of levels.
        marks: one-shots.
        locale: language of the interface.
    """

    kept: int | None
    waves: tuple[int, ...]
    size: tuple[int, int]
    scale: float
    frames: tuple[float, ...]
    first: tuple[str, str]
    colours: Colours
    wave: bool
    marks: tuple[Mark, ...]
    locale: str


class _Shown(NamedTuple):
    """The lane of a region as it is drawn.

    Attributes:
        view: what it was made from.
        under: grounds of the rows, on the GPU.
        shapes: the bands with their colours, on the GPU.
        over: names and symbols above the bands, on the GPU.
        marks: one-shots and their places [pixels], for the mouse.
        impacts: their frames (m,), for the mouse.
    """

    view: _View
    under: Uploaded
    shapes: tuple[tuple[Any, tuple[float, ...]], ...]
    over: Uploaded
    marks: tuple[tuple[Mark, Place], ...]
    impacts: FloatArray


# By session id of the scene: the range, the listeners and the rate; frames that were played.
_played: dict[int, tuple[Any, Waves]] = {}
_shown = Recent()  # by the region's address


def _keep(traced: sessions.Traced, frames: _Range, before: int | None) -> int:
    """Computed on the worker: store the samples of a frame. Returns the number of the last stored
    frame."""
    result = traced.result
    if traced.reading is None or result.block is None or not result.listeners:
        return 0 if before is None else before
    key = frames, tuple(item.name for item in result.listeners), result.sample_rate
    known = _played.get(frames.scene)
    if known is None or known[0] != key:
        count = math.ceil((frames.last - frames.first) * frames.seconds * result.sample_rate) + 1
        if 2 * count * len(result.listeners) > _MOST_BYTES:
            return traced.serial
        empty = np.zeros((len(result.listeners), count), dtype=np.int16)
        known = (
            key,
            Waves(key[1], frames.first, frames.seconds * result.sample_rate, empty, filled=False),
        )
        _played[frames.scene] = known
    latest = traced.samples[:, -round(LEVEL_SECONDS * result.sample_rate) :]
    felt = level_and_threshold(latest, result.sample_rate, result.listeners)
    waiting = {item.name: 0.0 for item in traced.reading.sources if item.triggers is not None}
    sounding = waiting | {
        row_name(item.name, item.second_object, item.onset): item.amplitude
        for item in result.sources
    }
    known[1].write(result.first_sample, result.block, *felt, sounding)
    _add_impacts(known[1], result, frames)
    return traced.serial


def _add_impacts(waves: Waves, result: FrameResult, frames: _Range) -> None:
    """Add the impacts that began in a frame."""
    start = result.first_sample / result.sample_rate
    begun = [
        k
        for k, item in enumerate(result.sources)
        if item.kind is SourceKind.TEMPORARY and start <= item.onset < result.time
    ]
    waves.add_impacts(
        frames.first + np.array([result.sources[k].onset for k in begun]) / frames.seconds,
        result.amplitudes[begun],
    )


_LAST_KEPT: Derived[_Range, int] = Derived(_keep, every_frame=True, hears=True)


def draw(baked: Waves | None) -> None:
    """Draw callback: the lane of a scene; ``baked``: the waves of the track that is played."""
    context = bpy.context
    scene: Any = context.scene
    if scene is None or scene.haptic_lane == "OFF":
        return
    haptics = scene.haptics
    frames = _Range(
        scene.session_uid,
        scene.frame_start,
        scene.frame_end,
        frame_seconds(scene),
        haptics.mode,
        haptics.strategy,
    )
    latest = _LAST_KEPT.latest(scene, frames)
    played = _played.get(scene.session_uid)
    sources = tuple(
        waves for waves in (baked, None if played is None else played[1]) if waves is not None
    )
    if sources:
        _draw_lane(context, scene, sources, None if latest is None else latest.value)


def _draw_lane(context: Context, scene: Any, sources: tuple[Waves, ...], kept: int | None) -> None:
    region = context.region
    scale = pixels_per_point(context)
    size = region.width, region.height
    view = _View(
        kept,
        tuple(map(id, sources)),
        size,
        scale,
        tuple(region.view2d.region_to_view(x, 0)[0] for x in (0, region.width)),
        (watched(scene), active_name()),
        _theme(context, size[1] > SMALL * scale),
        scene.haptic_lane == "WAVES",
        tuple(mark for waves in sources for name in waves.sources for mark in marks_of(name)),
        bpy.app.translations.locale,
    )
    known: _Shown | None = _shown.get(region.as_pointer())
    if known is None or known.view != view:
        known = _shown[region.as_pointer()] = _lane(sources, view)
    draw_flat(known.under, size, scale)
    gpu.state.blend_set("ALPHA")
    program = gpu.shader.from_builtin("UNIFORM_COLOR")
    program.bind()
    for batch, colour in known.shapes:
        program.uniform_float("color", colour)
        batch.draw(program)
    gpu.state.blend_set("NONE")
    draw_flat(known.over, size, scale)


def _theme(context: Context, covers: bool) -> Colours:
    """The colours of the theme in use; the ground ``covers`` keyframes, or lets them through."""
    theme = context.preferences.themes[0]
    space, icons = theme.dopesheet_editor.space, theme.user_interface
    own = tuple(icons.icon_object)[:3], tuple(icons.icon_object_data)[:3]
    return Colours((*space.back, 0.8 if covers else 0.3), tuple(space.text_hi), *own)


def marks_of(name: str) -> tuple[Mark, ...]:
    """The one-shots that are keyframes of a source's trigger."""
    obj = bpy.data.objects.get(name)
    curve = None if obj is None or not obj.haptics.source.one_shot else trigger_curve(obj)
    if curve is None:
        return ()
    keys = read_array(curve.keyframe_points, "co", 2).tolist()
    return tuple(Mark(name, k, frame) for k, (frame, value) in enumerate(keys) if value > 0)


def trigger_curve(obj: Any) -> Any:
    """The F-curve of a source's trigger, None without one."""
    return next((curve for curve in fcurves_of(obj) if curve.data_path == PATH), None)


def _lane(sources: tuple[Waves, ...], view: _View) -> _Shown:
    """The lane on the GPU. ``sources``: the first that contains a frame is drawn."""
    _, _, size, scale, frames, first, colours, wave, marks, _ = view
    emitting, felt = (
        tuple(dict.fromkeys(name for waves in sources for name in getattr(waves, kind)))
        for kind in ("sources", "listeners")
    )
    rows = rows_of(emitting, felt, first, size[1], scale)
    x = np.arange(0.0, size[0] + 1)
    per_pixel = (frames[1] - frames[0]) / size[0]
    edges = frames[0] + x * per_pixel
    free = np.ones(size[0], dtype=np.bool_)
    shapes: list[tuple[Any, tuple[float, ...]]] = []
    for waves in sources if rows else ():
        parts = waves.columns(edges)
        parts = replace(parts, known=parts.known & free)
        free &= ~parts.known
        for kind, own, low, high in _bands(waves, rows, parts, edges, wave):
            corners = strip(own, x[:-1] + 0.5, low, high, parts.known)
            colour = colours.source if own[0].is_source else colours.listener
            shapes.append((_batch("TRI_STRIP", corners), (*colour, _OPACITY[kind])))
        own = [row for row in rows if row.name in waves.listeners and not row.is_source]
        begun, gains = waves.impacts
        at = (begun - edges[0]) / per_pixel
        is_shown = (at >= 0) & (at < size[0])
        is_shown[is_shown] = parts.known[at[is_shown].astype(np.int64)]
        felt_gains = gains[is_shown][:, [waves.listeners.index(row.name) for row in own]]
        if own and felt_gains.any():
            ends = stems(own, at[is_shown], felt_gains)
            shapes.append((_batch("LINES", ends), (*colours.ink, 0.7)))
    middles = {row.name: row.low + row.height / 2 for row in rows if row.is_source}
    if rows:  # the active source can be edited where it has no row
        middles.setdefault(first[1], rows[-1].low + rows[-1].height / 2)
    placed = tuple(
        (mark, ((mark.frame - edges[0]) / per_pixel, middles[mark.source]))
        for mark in marks
        if mark.source in middles
    )
    over = names(
        rows,
        [place for _, place in placed],
        len(emitting) + len(felt) - len(rows),
        colours,
        scale,
    )
    return _Shown(
        view,
        uploaded(grounds(rows, size[0], colours)),
        tuple(shapes),
        uploaded(over),
        placed,
        np.concatenate([waves.impacts[0] for waves in sources]),
    )


def _bands(
    waves: Waves, rows: tuple[LaneRow, ...], parts: Any, edges: FloatArray, wave: bool
) -> Any:
    """What is drawn of some waves: kind of band, rows, and lower and upper ends (r, c) in them.

    Args:
        waves: of listeners and sources.
        rows: of the lane.
        parts: the columns of the waves.
        edges: of the columns (c + 1,), in frames.
        wave: whether waves are drawn in place of levels.
    """
    own = [row for row in rows if row.name in waves.sources and row.is_source]
    if own:
        levels = np.array([waves.sources[row.name] for row in own])
        height = height_of(waves.highest(levels, edges))
        yield "amplitude", own, height, height
    own = [row for row in rows if row.name in waves.listeners and not row.is_source]
    numbers = [waves.listeners.index(row.name) for row in own]
    if not own:
        return
    for kind, low, high in (wave_band(parts),) if wave else bands(parts.level, parts.threshold):
        yield kind, own, low[numbers], high[numbers]


def _batch(kind: str, corners: Any) -> Any:
    program = gpu.shader.from_builtin("UNIFORM_COLOR")
    return batch_for_shader(program, kind, {"pos": corners})


def under(context: Any, mouse: Place) -> Mark | None:
    """The one-shot within reach of the mouse [pixels of the region]."""
    known: _Shown | None = _shown.get(context.region.as_pointer())
    if known is None or context.scene.haptic_lane == "OFF":
        return None
    near = [
        (math.dist(mouse, place), mark)
        for mark, place in known.marks
        if math.dist(mouse, place) <= _REACH * pixels_per_point(context)
    ]
    return min(near)[1] if near else None


def snap(context: Context, x: float) -> float:
    """The frame at ``x`` [pixels of the region]: that of an impact or marker within reach, else a
    whole one."""
    view = context.region.view2d
    reach = _REACH * pixels_per_point(context)
    frame, end = (view.region_to_view(at, 0)[0] for at in (x, x + reach))
    known: _Shown | None = _shown.get(context.region.as_pointer())
    markers = [float(marker.frame) for marker in context.scene.timeline_markers]
    impacts = np.zeros(0) if known is None else known.impacts
    return snapped(frame, np.concatenate([impacts, markers]), end - frame)


file_changed.subscribe(_played.clear)
file_changed.subscribe(_shown.clear)
