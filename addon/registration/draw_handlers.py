"""What is drawn over the 3D viewport: the haptic graph, over it the meters."""

from __future__ import annotations

from ..view import meters, overlay


def register() -> None:
    """Start drawing."""
    overlay.register()
    meters.register()


def unregister() -> None:
    """Stop drawing."""
    meters.unregister()
    overlay.unregister()
