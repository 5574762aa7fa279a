"""Blender's scene, read into values of the core."""
