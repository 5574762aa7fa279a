"""Files: haptic scenes and tracks out of Blender, haptic scenes and signals into it, and haptics in
glTF."""
