"""Blender properties for everything that a designer authors."""
