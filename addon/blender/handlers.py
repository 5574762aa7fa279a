"""Handlers of Blender's events, added and removed together."""

from __future__ import annotations

import atexit
from collections.abc import Callable, Mapping

import bpy


def add(handlers: Mapping[str, Callable[..., None]]) -> None:
    """Add handlers by the names of their events; events that this Blender does not have are left out (``exit_pre`` came with 5.1).

    They are removed when Python ends: a Blender that is a module of Python ends later, when the names of modules are cleared.
    """
    atexit.register(remove, handlers)
    for event, handler in handlers.items():
        getattr(bpy.app.handlers, event, []).append(handler)


def remove(handlers: Mapping[str, Callable[..., None]]) -> None:
    """Remove those of the handlers that are present."""
    for event, handler in handlers.items():
        present = getattr(bpy.app.handlers, event, [])
        if handler in present:
            present.remove(handler)
