"""Draws the meters over every 3D viewport: one draw call, rebuilt when another frame was traced."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import bpy
from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Context, Scene, SpaceView3D

from ...core.render.frame_result import FrameResult
from ...core.render.history import History
from ..changes.redraw import SIDEBAR_TAB
from ..properties.preferences import preferences
from ..session import session
from . import shader
from .annotations import Furniture, Rectangle, legend_width, moved, plate_of
from .layout import free_rectangle
from .levels import Level, levels
from .meter_board import Scope, meters
from .quads import quads_of
from .screen import draw_flat, shared_atlas, text_width

_MARGIN = 12.0  # points to the edges of what is free
_SHARE = 0.6  # of the free height
_LEAST_WIDTH = 320.0  # points: with less than that beside it, the legend stands above

_PANEL_SECONDS = 0.1

_handlers: list[Any] = []


@dataclass(slots=True)
class _Shown:
    """The meters of a view as they are on the GPU, and what they were made of."""

    result: FrameResult
    key: Any
    batch: Any
    generation: int
    place: tuple[Rectangle, ...]


_shown: dict[int, _Shown] = {}  # by the region's address
_refreshed: dict[int, float] = {}  # when a sidebar was drawn again last, by the region's address
_levels: dict[int, tuple[FrameResult, tuple[Level, ...]]] = {}  # by session id of the scene


def levels_of(scene: Scene) -> tuple[Level, ...]:
    """The levels of the scene's last frame, worked out once."""
    result = session.result_of(scene)
    if result is None:
        return ()
    known = _levels.get(scene.session_uid)
    if known is None or known[0] is not result:
        for gone in _levels.keys() - {other.session_uid for other in bpy.data.scenes}:
            del _levels[gone]
        known = (result, levels(result, session.of(scene).history))
        _levels[scene.session_uid] = known
    return known[1]


def watched(scene: Scene) -> str:
    """The listener whose scope is drawn: the active object, else the one that feels the most; "" for none."""
    shown = levels_of(scene)
    active = bpy.context.view_layer.objects.active
    if active is not None and any(level.listener == active.name_full for level in shown):
        return active.name_full
    return max(shown, key=lambda level: level.rms).listener if shown else ""


def scope_of(scene: Scene) -> Scope | None:
    """The last second of the listener that is watched; None where there is nothing of it, or where it is not to be drawn."""
    name, history = watched(scene), session.of(scene).history
    if not scene.haptics.meters.show_scope or not name or not history.sample_rate:
        return None
    return Scope(name, history.samples(name), history.sample_rate)


def board_of(scene: Scene, corner: tuple[float, float], room: tuple[float, float], scale: float) -> Furniture:
    """The scene's meters as shapes."""
    title, body = iface_("Mode {}").format(scene.haptics.mode), scene.haptics.meters.show_body
    return meters(levels_of(scene), scope_of(scene), corner, room, scale, text_width, title=title, body=body)


def meters_above(scene: Scene, result: FrameResult, size: tuple[int, int], scale: float) -> Furniture:
    """The meters at the upper left of a picture."""
    shown, margin = levels(result, History()), 12 * scale
    room = (0.35 * size[0], 0.5 * size[1])
    items = meters(shown, None, (0.0, 0.0), room, scale, text_width, title=iface_("Mode {}").format(scene.haptics.mode))
    high = max((plate[3] for plate in plate_of(items)), default=0.0)
    return moved(items, round(margin), round(size[1] - margin - high))


def _draw_pixels() -> None:
    context = bpy.context
    scene, space = context.scene, context.space_data
    if scene is not None and space is not None:
        _refresh_panels(context)
    if scene is None or space is None or not scene.haptics.meters.show or not space.overlay.show_overlays:
        return
    result = session.result_of(scene)
    if result is None or not result.listeners:
        _shown.pop(context.region.as_pointer(), None)
        return
    with session.drawing(scene):
        draw_board(context, scene, result)


def _refresh_panels(context: Context) -> None:
    """Have the sidebar drawn again: while the timeline plays, Blender leaves it as it is. Not more often than one can read."""
    if context.screen is None or not context.screen.is_animation_playing:
        return
    now = time.perf_counter()
    for region in context.area.regions:
        if region.type != "UI" or region.width <= 1 or region.active_panel_category != SIDEBAR_TAB:
            continue
        address = region.as_pointer()
        if now - _refreshed.get(address, 0.0) >= _PANEL_SECONDS:
            if len(_refreshed) > 16:
                _refreshed.clear()
            _refreshed[address] = now
            region.tag_redraw()


def draw_board(context: Context, scene: Scene, result: FrameResult) -> None:
    """The meters at the lower left of what is free of the viewport."""
    region, scale = context.region, context.preferences.system.ui_scale * preferences().overlay_size
    left, bottom, right, top = free_rectangle(context)
    margin = _MARGIN * scale
    corner = (round(left + margin), round(bottom + margin))
    width = right - left - 2 * margin
    beside_legend = width - legend_width(scale, text_width) - margin
    if scene.haptics.show_overlay and beside_legend >= _LEAST_WIDTH * scale:
        width = beside_legend
    room = (width, _SHARE * (top - bottom) - margin)
    chosen = scene.haptics.meters
    atlas = shared_atlas()
    key = (corner, room, scale, chosen.show_scope, chosen.show_body, scene.haptics.mode, watched(scene), bpy.app.translations.locale)
    known = _shown.get(region.as_pointer())
    if known is None or known.result is not result or known.key != key or known.generation != atlas.generation:
        items = board_of(scene, corner, room, scale)
        batch = shader.upload(quads_of((items.lines, atlas.lines(items.texts)), items.points))
        known = _Shown(result, key, batch, atlas.generation, plate_of(items))
        if len(_shown) > 16:
            _shown.clear()
        _shown[region.as_pointer()] = known
    draw_flat(known.batch, (region.width, region.height), scale)


def taken(context: Context) -> tuple[Rectangle, ...]:
    """What the meters cover of the region, as they were last drawn."""
    known = _shown.get(context.region.as_pointer())
    return known.place if known is not None and context.scene.haptics.meters.show else ()


def forget() -> None:
    """Drop what is kept between redraws."""
    _shown.clear()
    _refreshed.clear()
    _levels.clear()


def register() -> None:
    """Add the draw handler, once."""
    if not _handlers:
        _handlers.append(SpaceView3D.draw_handler_add(_draw_pixels, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    """Remove the draw handler and forget what it drew."""
    while _handlers:
        SpaceView3D.draw_handler_remove(_handlers.pop(), "WINDOW")
    forget()
