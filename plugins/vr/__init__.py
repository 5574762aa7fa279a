"""VR sessions of Blender: the controllers as a device, and hands that touch."""
