"""Registration with Blender: classes, handlers, menus, shortcuts and translations."""

from __future__ import annotations

from .. import translations
from . import classes, draw_handlers, handlers, keymaps, menus, properties

_PARTS = (properties, classes, menus, draw_handlers, handlers, keymaps, translations)
"""Each with `register` and `unregister`, in the order of registration."""


def register() -> None:
    """Register everything."""
    for part in _PARTS:
        part.register()


def unregister() -> None:
    """Remove what `register` added, in reverse order."""
    for part in reversed(_PARTS):
        part.unregister()
