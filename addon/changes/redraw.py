"""Requests to redraw parts of Blender's windows."""

from __future__ import annotations

from collections.abc import Iterator

import bpy
from bpy.types import Area

SIDEBAR_TAB = "Haptics"
"""Tab of the 3D viewport's sidebar that holds the add-on's panels."""


def redraw_viewports() -> None:
    """Request a redraw of every 3D viewport of every window, of the timelines, and of panels
    elsewhere."""
    for area in _areas("VIEW_3D", "DOPESHEET_EDITOR", "PROPERTIES"):
        area.tag_redraw()


def redraw_sidebars() -> None:
    """Request a redraw of the panels: in the sidebar of every 3D viewport, and in the tabs Scene
    and Object of Properties."""
    for area in _areas("VIEW_3D", "PROPERTIES"):
        for region in area.regions:
            if region.type == "UI" or area.type == "PROPERTIES":
                region.tag_redraw()


def _areas(*kinds: str) -> Iterator[Area]:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in kinds and (
                area.type != "PROPERTIES" or area.spaces.active.context in ("SCENE", "OBJECT")
            ):
                yield area
