"""Modalities beside vibration: their properties and panels follow from the data in `core.modalities`."""

from __future__ import annotations


def register() -> None:
    """Show the panels; the property groups are registered with the objects' and the scene's."""
    from . import panels

    panels.register()


def unregister() -> None:
    """Take the panels away and forget what was felt."""
    from . import feeling, panels

    panels.unregister()
    feeling.forget()
