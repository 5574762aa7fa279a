"""Requests to draw parts of Blender's windows again."""

from __future__ import annotations

from collections.abc import Iterator

import bpy
from bpy.types import Area

SIDEBAR_TAB = "Haptics"
"""Tab of the 3D viewport's sidebar that holds the add-on's panels."""


def redraw_viewports() -> None:
    """Request a redraw of every 3D viewport of every window."""
    for area in _viewports():
        area.tag_redraw()


def redraw_sidebars() -> None:
    """Request a redraw of the sidebar of every 3D viewport."""
    for area in _viewports():
        for region in area.regions:
            if region.type == "UI":
                region.tag_redraw()


def _viewports() -> Iterator[Area]:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                yield area
