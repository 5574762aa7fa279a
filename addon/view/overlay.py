"""Draws the haptic graph over every 3D viewport: handlers, and what they keep between redraws.

A redraw with nothing changed compares one signature and issues two draw calls: one for the graph, one for labels and legend.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, field
from typing import Any

import bpy
import gpu
import numpy as np
from bpy.types import Context, Scene, SpaceView3D

from ...core.render.frame_result import FrameResult
from ...core.scene.values import Settings
from ..blender.time import seconds_of
from ..properties.preferences import preferences
from ..scene_reader.settings import read_settings
from ..session import session
from . import meters, shader
from .annotations import Rectangle, furniture
from .colour_map import FloatArray
from .layout import free_rectangle
from .options import options_of
from .quads import quads, quads_of
from .render_data import Options, RenderData, render_data
from .screen import draw_flat, free_texts, shared_atlas, text_width

HIDDEN = 0.15  # opacity of what objects hide, where the graph is not drawn in front
PULSE_LENGTH = 0.8  # metres between two pulses of the signal flow
PULSE_SPEED = 1.6  # metres per second of the timeline

_handlers: list[Any] = []
_drawings: dict[int, Drawing] = {}  # by session id of the scene
_KEPT_VIEWS = 8


@dataclass(slots=True)
class Drawing:
    """A frame's data and its batch on the GPU; labels and legend per view."""

    result: FrameResult
    settings: Settings
    options: Options
    data: RenderData
    batch: Any
    locale: str  # of its words
    views: OrderedDict[Any, Any] = field(default_factory=OrderedDict)

    def shows(self, result: FrameResult) -> bool:
        """Whether another frame would look the same: the tracer keeps graph and gains while nothing in them changes."""
        return self.result.graph is result.graph and self.result.propagation is result.propagation


def drawing_of(scene_id: int, result: FrameResult, settings: Settings, options: Options) -> Drawing:
    """What is drawn of ``result``, kept until what it shows, the settings, the options or the language change."""
    known = _drawings.get(scene_id)
    locale = bpy.app.translations.locale
    if known is not None and known.shows(result) and (known.settings, known.options, known.locale) == (settings, options, locale):
        return known
    for gone in _drawings.keys() - {scene.session_uid for scene in bpy.data.scenes}:
        del _drawings[gone]
    data = render_data(result, settings, options)
    drawing = Drawing(result, settings, options, data, shader.upload(quads(data)), locale)
    _drawings[scene_id] = drawing
    return drawing


def draw_graph(
    drawing: Drawing, projection: Any, view: Any, size: tuple[float, float], scale: float, *, xray: bool, flow: float | None
) -> None:
    """Lines and points, in world space. ``flow``: seconds of the signal flow, None for no flow."""
    if drawing.batch is None:
        return
    passes = (("NONE", 1.0),) if xray else (("GREATER", HIDDEN), ("LESS_EQUAL", 1.0))
    gpu.state.blend_set("ALPHA_PREMULT")
    gpu.state.depth_mask_set(False)
    try:
        for test, opacity in passes:
            gpu.state.depth_test_set(test)
            shader.draw(
                drawing.batch,
                projection @ view,
                size,
                pixels_per_point=scale,
                bias=depth_bias(projection),
                flow=(0.0, 0.0) if flow is None else (flow * PULSE_SPEED / PULSE_LENGTH, PULSE_LENGTH),
                opacity=opacity,
            )
    finally:
        gpu.state.depth_test_set("NONE")
        gpu.state.blend_set("NONE")


def depth_bias(projection: Any) -> tuple[float, float]:
    """How far things come towards the viewer, so that what lies on a surface is seen whole: 1 % of the distance in perspective,
    2 cm in an orthographic view."""
    orthographic = projection[3][3] == 1.0
    return (0.0, 0.02 * abs(projection[2][2])) if orthographic else (0.01, 0.0)


def draw_furniture(
    drawing: Drawing,
    perspective: FloatArray,
    size: tuple[float, float],
    scale: float,
    free: Rectangle,
    taken: tuple[Rectangle, ...] = (),
) -> None:
    """Labels and legend, in pixels; within ``free`` and off what is ``taken``."""
    atlas = shared_atlas()
    key = (perspective.tobytes(), size, scale, free, taken)
    known = drawing.views.get((*key, atlas.generation))
    if known is None:
        items = furniture(drawing.data, perspective, size, scale, free, text_width, taken)
        texts = atlas.lines(items.texts)
        known = shader.upload(quads_of((items.lines, texts), items.points))
        drawing.views[(*key, atlas.generation)] = known
        while len(drawing.views) > _KEPT_VIEWS:
            drawing.views.popitem(last=False)
    draw_flat(known, size, scale)


def _shown(context: Context) -> tuple[Scene, FrameResult] | None:
    scene, space = context.scene, context.space_data
    if scene is None or space is None or not scene.haptics.show_overlay or not space.overlay.show_overlays:
        return None
    result = session.result_of(scene)
    if result is None:
        _drawings.pop(scene.session_uid, None)
        return None
    return scene, result


def _draw_view() -> None:
    context = bpy.context
    if context.scene is not None:
        session.of(context.scene).draw_milliseconds = 0.0  # this comes first in a redraw
    shown = _shown(context)
    if shown is None:
        return
    scene, result = shown
    region, view = context.region, context.region_data
    with session.drawing(scene):
        draw_graph(
            drawing_of(scene.session_uid, result, read_settings(scene), options_of(scene, result)),
            view.window_matrix,
            view.view_matrix,
            (region.width, region.height),
            context.preferences.system.ui_scale * preferences().overlay_size,
            xray=scene.haptics.xray,
            flow=seconds_shown(scene) if scene.haptics.show_flow else None,
        )


def _draw_pixels() -> None:
    context = bpy.context
    shown = _shown(context)
    drawing = _drawings.get(shown[0].session_uid) if shown is not None else None  # `_draw_view` has just drawn it
    if shown is None or drawing is None:
        return
    region = context.region
    perspective = np.array(context.region_data.perspective_matrix, dtype=np.float64)
    with session.drawing(shown[0]):
        draw_furniture(
            drawing,
            perspective,
            (region.width, region.height),
            context.preferences.system.ui_scale * preferences().overlay_size,
            free_rectangle(context),
            meters.taken(context),
        )


def seconds_shown(scene: Scene) -> float:
    """Where the signal flow stands: it moves with the timeline."""
    return seconds_of(scene, scene.frame_current_final)


def forget() -> None:
    """Drop what is kept between redraws."""
    _drawings.clear()
    free_texts()


def register() -> None:
    """Add the draw handlers, once."""
    if not _handlers:
        _handlers.append(SpaceView3D.draw_handler_add(_draw_view, (), "WINDOW", "POST_VIEW"))
        _handlers.append(SpaceView3D.draw_handler_add(_draw_pixels, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    """Remove the draw handlers and free what they drew."""
    while _handlers:
        SpaceView3D.draw_handler_remove(_handlers.pop(), "WINDOW")
    forget()
