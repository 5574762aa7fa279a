"""Blender's virtual-reality session: its controllers as a device."""
