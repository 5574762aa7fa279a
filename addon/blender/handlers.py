"""Handlers of Blender's events, added and removed together."""

from __future__ import annotations

import atexit
from collections.abc import Callable

import bpy


class Handlers(dict[str, Callable[..., None]]):
    """Handlers by the names of their events; events that this Blender does not have are left out
    (``exit_pre`` came with 5.1)."""

    def add(self) -> None:
        """Add the handlers.

        They are also removed when Python ends: Blender as a Python module ends later and would call
        them after their modules are cleared.
        """
        atexit.register(self.remove)
        for event, handler in self.items():
            getattr(bpy.app.handlers, event, []).append(handler)

    def remove(self) -> None:
        """Remove those that are present."""
        atexit.unregister(self.remove)
        for event, handler in self.items():
            present = getattr(bpy.app.handlers, event, [])
            if handler in present:
                present.remove(handler)
