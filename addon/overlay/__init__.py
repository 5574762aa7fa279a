"""The haptic graph drawn over the 3D viewport, in pictures and as geometry."""

from __future__ import annotations


def register() -> None:
    """Start drawing, and offer the graph as geometry."""
    from . import draw, geometry

    geometry.register()
    draw.register()


def unregister() -> None:
    """Stop drawing."""
    from . import draw, geometry

    draw.unregister()
    geometry.unregister()
