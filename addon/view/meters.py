"""The meters over every 3D viewport: one draw call, rebuilt when another frame is shown."""

from __future__ import annotations

import time
from collections.abc import Sequence

import bpy
from bpy.types import Context, Scene

from ...core.scene.body_map import Spot
from ...core.scene.values import MODES, Mode
from ..blender.full_names import object_named
from ..blender.time import is_playing
from ..blender.words import ui_text
from ..changes.events import file_changed
from ..changes.redraw import SIDEBAR_TAB
from ..session import sessions
from .hud import Hud, Rectangle, Target, overlaps
from .layout import corner_room, free_rectangle, is_main_view, pixels_per_point
from .meter_layout import SWITCHES, meter_hud
from .screen import Recent, draw_flat, in_theme, is_light, uploaded
from .watched import levels_of, watched

_MARGIN = 12.0  # points to the edges of the free part of the viewport
# Parts of the viewport's width, the greater one where the least width [points] needs it, and of the
# height of its free part.
_SHARE_ACROSS, _MOST_ACROSS, _LEAST_WIDTH, _SHARE_UP = 0.25, 0.45, 290.0, 0.6
_PANEL_SECONDS = 0.1


# By the region's address: the values that its meters were made from, these on the GPU, and their
# layout.
_shown = Recent()
_refreshed = Recent()  # time of the last redraw of a sidebar, by the region's address
_redo_panels = Recent()  # places of the panel Adjust Last Operation, by the area's address


def draw_pixels(spots: Sequence[Spot] = ()) -> None:
    """Draw callback: the meters, with the actuators that play at ``spots``."""
    context = bpy.context
    scene, space = context.scene, context.space_data
    if scene is None or space is None:
        return
    _refresh_panels(context)
    meters = scene.haptics.meters
    if not (meters.show and space.overlay.show_overlays and is_main_view(context)):
        return
    if not levels_of(scene):
        _shown.pop(context.region.as_pointer(), None)
        return
    _draw_meters(context, scene, spots)


def draw_redo_panel() -> None:
    """Draw callback: redraw the viewport when the panel Adjust Last Operation, laid out after it,
    has moved."""
    area = bpy.context.area
    place = tuple(
        (region.x, region.y, region.width, region.height)
        for region in area.regions
        if region.type == "HUD"
    )
    if _redo_panels.get(area.as_pointer()) == place:
        return
    _redo_panels[area.as_pointer()] = place
    for region in area.regions:
        if region.type == "WINDOW":
            region.tag_redraw()


def _refresh_panels(context: Context) -> None:
    """Redraw sidebar and lanes during playback, which Blender does not do, at a readable rate."""
    if context.screen is None or not context.screen.is_animation_playing:
        return
    now = time.perf_counter()
    sidebars = (
        r
        for r in context.area.regions
        if r.type == "UI" and r.width > 1 and r.active_panel_category == SIDEBAR_TAB
    )
    lanes = (
        r
        for area in context.screen.areas
        if area.type == "DOPESHEET_EDITOR"
        for r in area.regions
        if r.type == "WINDOW"
    )
    for region in (*sidebars, *lanes):
        address = region.as_pointer()
        if now - _refreshed.get(address, 0.0) >= _PANEL_SECONDS:
            _refreshed[address] = now
            region.tag_redraw()


def _draw_meters(context: Context, scene: Scene, spots: Sequence[Spot]) -> None:
    """Draw the meters in their corner of the viewport, made again if anything has changed that they
    depend on."""
    region, chosen, scale = context.region, scene.haptics.meters, pixels_per_point(context)
    corner: str = chosen.corner
    margin = _MARGIN * scale
    width = max(_SHARE_ACROSS * region.width, _LEAST_WIDTH * scale)
    width = min(width, _MOST_ACROSS * region.width)
    room = corner_room(context, corner, width, scale, margin)
    traced, levels = sessions.shown(scene), levels_of(scene)
    is_late = sessions.is_behind(scene) and not is_playing()
    title = ui_text("Tracing..." if is_late else MODES[Mode(scene.haptics.mode)][0])
    switched = {level.listener: _switched(level.listener) for level in levels}
    key = (
        (traced and traced.serial, levels, spots, room, scale, corner, title, watched(scene)),
        (tuple(switched.items()), chosen.show_body, bpy.app.translations.locale, is_light()),
    )
    known, batch, _ = _shown.get(region.as_pointer(), (None, None, None))
    if known != key:
        free = free_rectangle(context)
        size = room[2] - room[0], min(room[3] - room[1], _SHARE_UP * (free[3] - free[1]))
        body = chosen.show_body
        hud = meter_hud(
            levels,
            size,
            scale,
            title,
            body=body,
            spots=spots,
            switched=switched,
        )
        hud = _in_corner(hud, corner, room)
        batch = uploaded(in_theme(hud))
        _shown[region.as_pointer()] = key, batch, hud
    draw_flat(batch, (region.width, region.height), scale)


def _in_corner(hud: Hud, corner: str, room: Rectangle) -> Hud:
    """The meters moved to a corner of the room."""
    left, bottom, right, top = room
    width, height = (max((bounds[k] for bounds in hud.bounds), default=0.0) for k in (2, 3))
    return hud.moved(
        round(left if corner.endswith("LEFT") else right - width),
        round(bottom if corner.startswith("BOTTOM") else top - height),
    )


def occupied(context: Context) -> tuple[Rectangle, ...]:
    """The rectangles of the region that the meters cover."""
    hud = _layout_of(context)
    return () if hud is None else hud.bounds


def target_under(context: Context, mouse: tuple[float, float]) -> Target | None:
    """What of the meters is under the mouse [pixels of the viewport]."""
    hud = _layout_of(context)
    at = (*mouse, *mouse)
    found = (target for target in (() if hud is None else hud.targets) if overlaps(target.area, at))
    return next(found, None)


def _layout_of(context: Context) -> Hud | None:
    """The meters of a viewport, None where there are none."""
    if not (context.scene.haptics.meters.show and is_main_view(context)):
        return None
    *_, hud = _shown.get(context.region.as_pointer(), (None,))
    return hud


def switch(name: str, letter: str) -> None:
    """Turn a switch of a listener over."""
    obj = object_named(name)
    if obj is not None:
        listener = obj.haptics.listener
        setattr(listener, SWITCHES[letter], not getattr(listener, SWITCHES[letter]))


def _switched(name: str) -> str:
    """The letters of a listener's switches that are on."""
    obj = object_named(name)
    if obj is None:
        return ""
    return "".join(key for key, held in SWITCHES.items() if getattr(obj.haptics.listener, held))


for _kept in (_shown, _refreshed, _redo_panels):
    file_changed.subscribe(_kept.clear)
