"""The haptic graph drawn over the 3D viewport, in pictures and as geometry."""
