"""Rendering of gains to samples: voices, mixing and playback."""
