"""What a designer authors, as Blender properties."""
