"""The haptic scene as plain values: objects, sources, listeners, their functions, materials and
body parts."""
