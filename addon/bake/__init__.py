"""Baking: a frame range traced in order, kept with the scene as a haptic track, and played from there."""
