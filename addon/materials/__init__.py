"""Haptic materials: presets, a library that a scene's objects share, and the gain over distance as a picture."""

from __future__ import annotations


def register() -> None:
    """Offer the operators, menus and panels; the property groups are registered with the objects' and the scene's."""
    from . import operators, panels

    operators.register()
    panels.register()


def unregister() -> None:
    """Take them away, and the picture."""
    from . import operators, panels, plot

    panels.unregister()
    operators.unregister()
    plot.forget()
