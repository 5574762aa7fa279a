"""Baking: a frame range is traced in order, stored with the scene as a haptic track, and played
from there."""
