"""Helpers for Blender: differences between versions, jobs, handlers, texts."""
