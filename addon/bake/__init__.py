"""Baking: a frame range traced in order, kept with the scene as a haptic track, and played from there."""

from __future__ import annotations


def register() -> None:
    """Offer the operators and the panel; the property groups are registered with the scene's."""
    from . import operators, panels

    operators.register()
    panels.register()


def unregister() -> None:
    """Stop a bake that runs, forget the tracks that were read."""
    from . import operators, panels, playback

    panels.unregister()
    operators.unregister()
    playback.forget()
