"""What is drawn over the 3D viewport: the haptic graph, then the meters, then labels and legend where these leave room."""

from __future__ import annotations

from typing import Any

from bpy.types import SpaceView3D

from ..gateway import is_loaded
from ..session import session
from ..view import meters, overlay

_handlers: list[tuple[Any, str]] = []


def _draw_view() -> None:
    if is_loaded(session):
        overlay.draw_view()


def _draw_pixels() -> None:
    if is_loaded(session):
        meters.draw_pixels()
        overlay.draw_pixels()


def _draw_redo_panel() -> None:
    if is_loaded(session):
        meters.draw_redo_panel()


def register() -> None:
    """Start drawing, once."""
    if not _handlers:
        stages = ((_draw_view, "WINDOW", "POST_VIEW"), (_draw_pixels, "WINDOW", "POST_PIXEL"), (_draw_redo_panel, "HUD", "POST_PIXEL"))
        for function, region, stage in stages:
            _handlers.append((SpaceView3D.draw_handler_add(function, (), region, stage), region))


def unregister() -> None:
    """Stop drawing."""
    while _handlers:
        SpaceView3D.draw_handler_remove(*_handlers.pop())
