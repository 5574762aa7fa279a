"""Draws the haptic graph over every 3D viewport: handlers, and what they keep between redraws.

A redraw with nothing changed compares one signature and issues two draw calls: one for the graph, one for labels and legend.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, field
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np
from bpy.types import Context, Scene, SpaceView3D

from ...core.render.frame_result import FrameResult
from ...core.scene.values import Settings
from ..properties.preferences import preferences
from ..scene_reader import reader
from ..session import session
from .annotations import Furniture, Rectangle, furniture
from .colour_map import FloatArray
from .quads import quads, quads_of
from .render_data import Options, RenderData, render_data

if TYPE_CHECKING:
    from .text_atlas import TextAtlas

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
    from . import shader

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


def options_of(scene: Scene, result: FrameResult) -> Options:
    """The scene's choices, and which sources and listeners are selected."""
    haptics = scene.haptics
    return Options(
        show_intra=haptics.show_intra,
        show_best_paths=haptics.show_best_paths,
        show_labels=haptics.show_labels,
        sources=frozenset(source.name for source in result.sources if _is_selected(source.name)),
        listeners=frozenset(listener.name for listener in result.listeners if _is_selected(listener.name)),
    )


def _is_selected(full_name: str) -> bool:
    obj = bpy.data.objects.get(full_name)
    if obj is None and full_name.endswith("]"):
        name, _, library = full_name[:-1].rpartition(" [")
        linked = bpy.data.libraries.get(library)
        obj = bpy.data.objects.get((name, linked.filepath)) if linked is not None else None
    return obj is not None and obj.select_get()


def draw_graph(
    drawing: Drawing, projection: Any, view: Any, size: tuple[float, float], scale: float, *, xray: bool, flow: float | None
) -> None:
    """Lines and points, in world space. ``flow``: seconds of the signal flow, None for no flow."""
    import gpu

    from . import shader

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
    from . import shader

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


def draw_board(items: Furniture, size: tuple[float, float], scale: float) -> None:
    """Plates, lines, symbols and texts once, without keeping them."""
    from . import shader

    texts = shared_atlas().lines(items.texts)
    draw_flat(shader.upload(quads_of((items.lines, texts), items.points)), size, scale)


def draw_flat(batch: Any, size: tuple[float, float], scale: float) -> None:
    """One draw call in pixels of a viewport of ``size``; ``batch`` may be None."""
    import gpu

    from . import shader
    from .text_atlas import pixels_to_clip

    if batch is None:
        return
    gpu.state.blend_set("ALPHA_PREMULT")
    gpu.state.depth_test_set("NONE")
    shader.draw(batch, pixels_to_clip(size), size, pixels_per_point=scale, texts=shared_atlas().texture)
    gpu.state.blend_set("NONE")


@cache
def shared_atlas() -> TextAtlas:
    """The texture of all texts that are drawn over viewports."""
    from .text_atlas import TextAtlas

    return TextAtlas()


@lru_cache(maxsize=4096)
def text_width(words: str, size: float) -> float:
    """Width of a text in Blender's own font [pixels]."""
    import blf

    blf.size(0, size)
    return float(blf.dimensions(0, words)[0])


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
            drawing_of(scene.session_uid, result, reader.read_settings(scene), options_of(scene, result)),
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
    from . import meters

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
    return reader.seconds_of(scene, scene.frame_current_final)


def free_rectangle(context: Context) -> Rectangle:
    """What toolbar, sidebar and headers leave free of the viewport, in its pixels: they may lie over it."""
    region = context.region
    left, bottom, right, top = 0.0, 0.0, float(region.width), float(region.height)
    for other in context.area.regions:
        if other == region or other.width <= 1 or other.height <= 1:
            continue
        x, y = other.x - region.x, other.y - region.y
        if x >= region.width or y >= region.height or x + other.width <= 0 or y + other.height <= 0:
            continue  # beside the viewport, not over it
        if other.type in {"TOOLS", "UI"}:
            if 2 * x + other.width < region.width:
                left = max(left, float(x + other.width))
            else:
                right = min(right, float(x))
        elif other.type in {"HEADER", "TOOL_HEADER", "ASSET_SHELF", "ASSET_SHELF_HEADER"}:
            if 2 * y + other.height < region.height:
                bottom = max(bottom, float(y + other.height))
            else:
                top = min(top, float(y))
    return left, bottom, max(right, left), max(top, bottom)


def redraw() -> None:
    """Have every 3D viewport of every window drawn again."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def forget() -> None:
    """Drop what is kept between redraws."""
    _drawings.clear()
    if shared_atlas.cache_info().currsize:
        shared_atlas().free()


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
