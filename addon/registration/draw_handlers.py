"""What is drawn over the 3D viewport: the haptic graph, then the meters, then labels and legend where these leave room."""

from __future__ import annotations

from ..view import meters, overlay


def register() -> None:
    """Start drawing."""
    meters.register()
    overlay.register()


def unregister() -> None:
    """Stop drawing."""
    overlay.unregister()
    meters.unregister()
