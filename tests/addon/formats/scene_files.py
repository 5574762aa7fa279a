"""Haptic scenes out of Blender and back into an empty file."""

import bpy


def exported(path, **options):
    """The bytes of the current scene's file."""
    assert bpy.ops.export_scene.haptic_scene(filepath=str(path), **options) == {"FINISHED"}
    return path.read_bytes()


def imported(path):
    """Import into an empty file."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert bpy.ops.import_scene.haptic_scene(filepath=str(path)) == {"FINISHED"}
