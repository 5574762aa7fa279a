"""Fixtures in Blender."""

from in_blender import *  # noqa: F403
