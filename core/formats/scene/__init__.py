"""The haptic scene file."""
