"""The haptic graph, built from a scene and its contacts."""
