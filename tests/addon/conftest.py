"""What tests in Blender share."""

from in_blender import *  # noqa: F403
