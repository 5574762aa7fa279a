"""The timeline of touch, a lane over Dope Sheet and Timeline with the waveform of each listener in
all frames that were baked or played."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import blf
import bpy
import gpu
import numpy as np
from bpy.types import Context, Scene
from gpu_extras.batch import batch_for_shader

from ...core.render.frame_result import FrameResult
from ...core.render.waves import Waves, threshold_of
from ...core.scene.values import SourceKind
from ..blender.text import text_width
from ..blender.time import frame_seconds
from ..changes.events import file_changed
from ..session import sessions
from ..session.derived import Derived
from .hud import Hud, Text
from .lane_layout import impacts, names, plates, rows_of, threshold_strip, wave_strip
from .layout import pixels_per_point
from .levels import LEVEL_SECONDS
from .meter_layout import SCOPE_COLOUR
from .render_data import NO_LINES, SOURCE_COLOUR
from .screen import Recent, draw_flat, uploaded
from .watched import watched

_BOTTOM = 22.0  # points that Blender's scroll bar and markers take
_MOST_BYTES = 1 << 27
"""Largest size of the stored samples of played frames: 14 minutes of ten listeners."""
_WAVE_COLOUR, _THRESHOLD_COLOUR = (*SCOPE_COLOUR[:3], 0.9), (*SOURCE_COLOUR.tolist(), 0.8)


@dataclass(frozen=True, slots=True)
class _Range:
    """The frame range of a scene and the settings of its trace, which together identify stored
    waves."""

    scene: int  # session id
    first: int
    last: int
    seconds: float  # of a frame
    mode: str
    strategy: str


@dataclass(frozen=True, slots=True)
class _Shown:
    """The lane of a region on the GPU, and the values it was made from."""

    key: Any
    under: Any
    strips: tuple[tuple[Any, tuple[float, ...]], ...]
    over: Any
    texts: tuple[Text, ...]


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
    known[1].write(result.first_sample, result.block, threshold_of(latest, result.sample_rate))
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
    scene = context.scene
    if scene is None or not scene.haptics.meters.show_lane:
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


def _draw_lane(
    context: Context, scene: Scene, sources: tuple[Waves, ...], kept: int | None
) -> None:
    region, scale = context.region, pixels_per_point(context)
    size = region.width, region.height
    left, right = (region.view2d.region_to_view(x, 0)[0] for x in (0, region.width))
    chosen = watched(scene)
    key = (
        kept,
        tuple(map(id, sources)),
        size,
        scale,
        left,
        right,
        chosen,
        bpy.app.translations.locale,
    )
    known: _Shown | None = _shown.get(region.as_pointer())
    if known is None or known.key != key:
        known = _shown[region.as_pointer()] = _lane(
            key, sources, chosen, (left, right), size, scale
        )
    draw_flat(known.under, size, scale)
    gpu.state.blend_set("ALPHA")
    program = gpu.shader.from_builtin("UNIFORM_COLOR")
    program.bind()
    for batch, colour in known.strips:
        program.uniform_float("color", colour)
        batch.draw(program)
    gpu.state.blend_set("NONE")
    draw_flat(known.over, size, scale)
    # Not by the atlas, whose frame buffer belongs to the context in which viewports are drawn.
    for text in known.texts:
        blf.size(0, text.size)
        blf.color(0, *text.colour, 1.0)
        blf.position(0, *text.position, 0.0)
        blf.draw(0, text.words)


def _lane(
    key: Any,
    sources: tuple[Waves, ...],
    chosen: str,
    frames: tuple[float, float],
    size: tuple[int, int],
    scale: float,
) -> _Shown:
    """The lane on the GPU.

    Args:
        sources: the first that contains a frame is drawn.
        chosen: the listener that always has a row.
        frames: at the left and right edges of the region.
    """
    listeners = tuple(dict.fromkeys(name for waves in sources for name in waves.listeners))
    rows = rows_of(listeners, chosen, size[1], _BOTTOM * scale, scale)
    x = np.arange(0.0, size[0] + 1)
    edges, free = (
        frames[0] + x * (frames[1] - frames[0]) / size[0],
        np.ones(size[0], dtype=np.bool_),
    )
    strips: list[tuple[Any, tuple[float, ...]]] = []
    over = names(rows, len(listeners) - len(rows), scale, text_width)
    for waves in sources if rows else ():
        own = [row for row in rows if row.listener in waves.listeners]
        numbers = [waves.listeners.index(row.listener) for row in own]
        parts = waves.columns(edges)
        parts = replace(parts, known=parts.known & free)
        free &= ~parts.known
        shapes = (wave_strip, _WAVE_COLOUR), (threshold_strip, _THRESHOLD_COLOUR)
        for strip, colour in shapes if own else ():
            corners = {"pos": strip(own, x[:-1] + 0.5, parts, numbers)}
            strips.append(
                (
                    batch_for_shader(
                        gpu.shader.from_builtin("UNIFORM_COLOR"), "TRI_STRIP", corners
                    ),
                    colour,
                )
            )
        over = over.joined(
            Hud(NO_LINES, impacts(own, waves, numbers, edges, parts.known, scale), ())
        )
    return _Shown(
        key,
        uploaded(plates(rows, size[0], scale)),
        tuple(strips),
        uploaded(replace(over, texts=())),
        over.texts,
    )


file_changed.subscribe(_played.clear)
file_changed.subscribe(_shown.clear)
