"""Registration with Blender: classes, handlers, menus, shortcuts and translations."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

from ...core import plugins as found
from .. import translations
from . import classes, draw_handlers, handlers, keymaps, menus, plugins, properties

_PARTS = (properties, classes, draw_handlers, plugins, menus, handlers, keymaps, translations)
"""Each with `register` and `unregister`, in the order of registration; what plug-ins draw is over
the rest."""

_registered = False


def register() -> None:
    """Register everything."""
    global _registered
    for part in _PARTS:
        part.register()
    _registered = True


def unregister() -> None:
    """Remove what `register` added, in reverse order."""
    global _registered
    _registered = False
    for part in reversed(_PARTS):
        part.unregister()


def add_plugin(name: str, plugin: ModuleType) -> None:
    """Add a plug-in of another extension."""
    found.plugins()
    _anew(lambda: found.add(name, lambda: plugin))


def remove_plugin(name: str) -> None:
    """Remove a plug-in of another extension."""
    _anew(lambda: found.remove(name))


def _anew(change: Callable[[], None]) -> None:
    """Change the plug-ins; register everything again that was registered, because its classes
    follow from what the plug-ins offer."""
    was_registered = _registered
    if was_registered:
        unregister()
    change()
    if was_registered:
        register()
