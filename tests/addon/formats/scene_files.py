"""Haptic scenes out of Blender."""

import bpy


def exported(path, **options):
    """The bytes of the current scene's file."""
    assert bpy.ops.export_scene.haptic_scene(filepath=str(path), **options) == {"FINISHED"}
    return path.read_bytes()
