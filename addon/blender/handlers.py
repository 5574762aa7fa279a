"""Handlers of Blender's events, added and removed together."""

from __future__ import annotations

import atexit
from collections.abc import Callable

import bpy

_EXTENSION = __package__.removesuffix(".addon.blender")


def are_frames_shared() -> bool:
    """Whether others than this extension have handlers of frames: what these change, Blender
    evaluates after them, without an event."""
    return any(
        not getattr(handler, "__module__", "").startswith(_EXTENSION)
        for handler in bpy.app.handlers.frame_change_post
    )


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
