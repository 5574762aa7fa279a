"""Draw handlers: over the 3D viewport the haptic graph, the meters, then labels and legend in the
remaining room."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bpy.types import SpaceView3D

from ..gateway import is_loaded
from ..live_output import player
from ..session import session
from ..view import meters, overlay

_handlers: list[tuple[Any, str]] = []


def _draw(what: Callable[[], None]) -> None:
    """Draw, once anything has been traced."""
    if is_loaded(session):
        what()


def _draw_pixels() -> None:
    meters.draw_pixels(player.spots() if is_loaded(player) else ())
    overlay.draw_pixels()


_STAGES: tuple[tuple[Callable[[], None], str, str], ...] = (
    (lambda: overlay.draw_view(), "WINDOW", "POST_VIEW"),
    (_draw_pixels, "WINDOW", "POST_PIXEL"),
    (lambda: meters.draw_redo_panel(), "HUD", "POST_PIXEL"),
)


def register() -> None:
    """Start drawing, once."""
    if not _handlers:
        _handlers.extend(
            (SpaceView3D.draw_handler_add(_draw, (what,), region, stage), region)
            for what, region, stage in _STAGES
        )


def unregister() -> None:
    """Stop drawing."""
    while _handlers:
        SpaceView3D.draw_handler_remove(*_handlers.pop())
