"""Redraws the panel twice a second while a device is driven or a search runs, because Blender does
not notice changes of a device's state."""

from __future__ import annotations

import bpy

from ..changes.redraw import redraw_sidebars
from . import outputs

_SECONDS = 0.5


def start() -> None:
    """Redraw the panel until no device is driven and no search runs."""
    if not bpy.app.background and not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=0.1, persistent=True)


def stop() -> None:
    """Stop redrawing."""
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)


def _tick() -> float | None:
    redraw_sidebars()
    return _SECONDS if outputs.running() or outputs.is_finding() else None
