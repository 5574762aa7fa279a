"""Whether the timeline plays."""

from __future__ import annotations

import bpy


def is_playing() -> bool:
    """True while the timeline plays in the context's screen."""
    screen = bpy.context.screen
    return screen is not None and screen.is_animation_playing
