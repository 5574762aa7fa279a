"""What Blender lacks or does differently from version to version."""
