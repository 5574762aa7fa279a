"""The panel drawn anew twice a second while there is something to see: a device's state changes without Blender noticing."""

from __future__ import annotations

import bpy

from ..changes.redraw import redraw_sidebars
from . import outputs

_SECONDS = 0.5


def start() -> None:
    """Keep the panel fresh until no device is driven or looked for."""
    if not bpy.app.background and not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=0.1, persistent=True)


def stop() -> None:
    """No more."""
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)


def _tick() -> float | None:
    redraw_sidebars()
    return _SECONDS if outputs.running() or outputs.is_finding() else None


def unregister() -> None:
    stop()
